"""`[mqtt]`: each wrong key is a sentence at the start."""

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
    """An invalid broker URL is refused, one with a password too, which is not quoted."""
    assert 'allowed is empty, or an address as "mqtts://broker' in _problem({"url": url})
    assert "secret" not in _problem({"url": url})


@pytest.mark.parametrize("port", [0, 70000])
def test_a_port_can_be(port: int) -> None:
    """A port of 0 or above 65535 is refused."""
    assert "mqtt.url: Port" in _problem({"url": f"mqtt://home:{port}"})


@pytest.mark.parametrize(
    "topic",
    ["a/+/b", "home/#", "$SYS/rover", "/rover", "rover/", "a//b", "a\nb", "a\x9fb", "r" * 101],
)
def test_a_topic_has_no_wildcards(topic: str) -> None:
    """A topic with wildcards, or in the brokers' own namespace, is refused."""
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
    """Keys that depend on each other must be set together."""
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
    """Long names are refused, also where Home Assistant shows them."""
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
    """A broker URL that leads to this server or to the robot is refused."""
    assert says in _problem({"url": url}, robot=robot)
