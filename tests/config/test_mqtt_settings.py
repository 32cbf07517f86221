"""`[mqtt]`: each wrong key is a sentence, at the start."""

from __future__ import annotations

from typing import Any

import pytest

from wax.config import settings as config
from wax.errors import ConfigError


def _problem(mqtt: dict[str, Any] | None = None, **tables: Any) -> str:
    with pytest.raises(ConfigError) as refused:
        config.parse({"mqtt": mqtt or {}, **tables}, "robot.toml")
    _, problem = str(refused.value).splitlines()
    return problem.strip()


@pytest.mark.parametrize(
    "url",
    ["http://home", "mqtt://rover:secret@home", "mqtt://", "mqtt://home/x", "home", "mqtt://a b"],
)
def test_an_address_is_a_brokers(url: str) -> None:
    """A password in it would be in every log; this sentence has none either."""
    assert 'allowed is empty, or an address as "mqtts://broker' in _problem({"url": url})
    assert "secret" not in _problem({"url": url})


@pytest.mark.parametrize("port", [0, 70000])
def test_a_port_can_be(port: int) -> None:
    """Zero is none, nor is one beyond 65535."""
    assert "mqtt.url: Port" in _problem({"url": f"mqtt://home:{port}"})


@pytest.mark.parametrize(
    "topic",
    ["a/+/b", "home/#", "$SYS/rover", "/rover", "rover/", "a//b", "a\nb", "a\x9fb", "r" * 101],
)
def test_a_topic_has_no_wildcards(topic: str) -> None:
    """Nor what brokers keep for themselves."""
    assert "mqtt.topic: got" in _problem({"topic": topic})
    assert config.parse({"mqtt": {"topic": 'Flur "1"/Rövér 🤖'}}, "x").mqtt.topic


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"password_file": "/x"}, "there is a password_file without a user"),
        ({"url": "mqtt://home", "ca_file": "/x"}, "ca_file is for an encrypted connection"),
        ({"discovery": "home+"}, "mqtt.discovery: got"),
        ({"drives": True}, "mqtt.drives: there is no such key"),
    ],
)
def test_other_keys(keys: dict[str, Any], says: str) -> None:
    """What belongs together is there together."""
    assert says in _problem(keys)


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        ({"mqtt": {"user": "r" * 201}}, "mqtt.user: got"),
        ({"page": {"name": "🤖" * 41}}, "page.name: got"),
        ({"gauges": [{"name": "amps", "label": "r" * 200}]}, "gauges[0].label: got"),
    ],
)
def test_names_are_short(tables: dict[str, Any], says: str) -> None:
    """Those that Home Assistant shows, too."""
    assert says in _problem(**tables)


@pytest.mark.parametrize(
    ("url", "robot", "says"),
    [
        ("mqtt://localhost:8080", {}, "mqtt.url: localhost:8080 is this server itself"),
        (
            "mqtt://robot.local:5000",
            {"serial": {"url": "socket://robot.local:5000"}},
            "mqtt.url: robot.local:5000 is the robot's own line",
        ),
        (
            "mqtt://robot.local",
            {"serial": {"url": "socket://robot.local:1883"}},
            "mqtt.url: robot.local is the robot's own line",
        ),
    ],
)
def test_it_leads_neither_here_nor_to_the_robot(url: str, robot: dict[str, Any], says: str) -> None:
    """Bytes there might be taken for commands."""
    assert says in _problem({"url": url}, robot=robot)
