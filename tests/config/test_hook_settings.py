"""`[[hook]]`: which webhooks are refused at the start, with which sentence."""

from __future__ import annotations

from typing import Any

import pytest

from wax.config import settings as config
from wax.errors import ConfigError
from wax.protocol.events import NAMES


def _parse(url: str = "https://example.org/h", **more: Any) -> config.Settings:
    hook = {"url": url, "secret_file": "secret", **more.pop("hook", {})}
    return config.parse({"hook": [hook], **more}, "robot.toml")


def _problem(url: str = "https://example.org/h", **more: Any) -> str:
    with pytest.raises(ConfigError) as refused:
        _parse(url, **more)
    heading, problem = str(refused.value).splitlines()
    assert heading == "robot.toml: 1 problem:"
    return problem.strip()


@pytest.mark.parametrize(
    "url",
    [
        "ftp://example.org/h",
        "example.org/h",
        "//example.org/h",
        "javascript:alert(1)",
        "file:///etc/passwd",
        "https://",
        "https:///h",
        "https://ada:pass@example.org/h",
        "https://exa mple.org/h",
        "https://example\\.org/h",
        "https://example.org/h#part",
        "https://example.org:port/h",
        "https://example.org/a\nb",
        "",
    ],
)
def test_what_is_no_address_is_refused(url: str) -> None:
    """An invalid URL is refused with an example; so is a password, which logs would show."""
    assert _problem(url).startswith("hook[0].url: got ")
    assert 'allowed is an address as "https://example.org/hook"' in _problem(url)


@pytest.mark.parametrize("url", ["http://example.org:0/", "http://example.org:70000/"])
def test_a_port_that_is_none_is_refused(url: str) -> None:
    """An invalid port is refused at the start."""
    assert _problem(url).startswith("hook[0].url: Port ")


def test_an_unknown_event_is_answered_with_all_that_there_are() -> None:
    """An unknown event is refused with a list of all events."""
    problem = _problem(hook={"events": ["turn.began", "turn.stopped"]})
    assert problem.startswith('hook[0].events[1]: got "turn.stopped"; allowed is "server.ready", ')
    assert all(f'"{name}"' in problem for name in NAMES)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"secret_file": ""}, 'hook[0].secret_file: got ""; allowed is a text that is not empty'),
        (
            {"ca_file": "/x", "url": "http://home/h"},
            "hook[0]: ca_file is for an encrypted connection; write url as https://",
        ),
        ({"retries": 3}, "hook[0].retries: there is no such key"),
        ({"names": "yes"}, 'hook[0].names: got "yes"; allowed is true or false'),
    ],
)
def test_other_keys(keys: dict[str, Any], says: str) -> None:
    """Each wrong key is a sentence."""
    assert _problem(hook=keys) == says


def test_a_secret_must_be_named() -> None:
    """A hook without a secret is refused, since unsigned events cannot be trusted."""
    with pytest.raises(ConfigError, match=r"hook\[0\]\.secret_file: is missing"):
        config.parse({"hook": [{"url": "https://example.org/"}]}, "robot.toml")


@pytest.mark.parametrize(
    "url",
    [
        "http://localhost:8080/x",
        "http://LocalHost.:8080/x",
        "http://127.0.0.1:8080/x",
        "http://127.1.2.3:8080/x",
        "http://[::1]:8080/x",
        "http://0.0.0.0:8080/x",
        "https://robot.example.org:8080/x",
        "http://192.0.2.7:8080/x",
        "http://Müller.example:8080/x",
    ],
)
def test_the_servers_own_port_is_refused(url: str) -> None:
    """The server's own port is refused by each name and address in the configuration."""
    server: dict[str, Any] = {"host": "192.0.2.7", "public_url": "https://robot.example.org"}
    server["names"] = ["xn--mller-kva.example"]
    assert "is this server itself; name the program" in _problem(url, server=server)


@pytest.mark.parametrize(
    ("url", "robot"),
    [
        ("http://robot.local:5000/", {"serial": {"url": "socket://robot.local:5000"}}),
        ("http://ROBOT.local:5000/", {"serial": {"url": "rfc2217://robot.local:5000"}}),
        ("http://localhost:5000/", {"serial": {"url": "socket://127.0.0.1:5000"}}),
        (
            "http://10.0.0.2:9090/",
            {
                "driver": "ros2",
                "ros2": {"transport": "rosbridge", "rosbridge_url": "ws://10.0.0.2:9090"},
            },
        ),
        (
            "http://10.0.0.2:5760/",
            {"driver": "mavlink", "mavlink": {"url": "tcp:10.0.0.2:5760"}},
        ),
    ],
)
def test_the_robots_line_is_refused(url: str, robot: dict[str, Any]) -> None:
    """The robot's own connection is refused, since a robot may take a POST for commands."""
    assert "is the robot's own line; name the program" in _problem(url, robot=robot)


def test_the_line_of_the_person_aboard_is_refused() -> None:
    """The hand control's connection is refused: its adapter may accept only one client."""
    local = {"source": "serial", "url": "socket://10.0.0.2:4000"}
    assert "is the robot's own line" in _problem("http://10.0.0.2:4000/", local=local)


@pytest.mark.parametrize(
    "url",
    [
        "http://localhost:1880/events?key=1",
        "https://example.org",
        "http://[2001:db8::7]/h",
        "https://robot.example.org/hook",
        "http://other.example.org:8080/",
    ],
)
def test_anybody_else_may_be_told(url: str) -> None:
    """Any other program is accepted, even on this machine or behind the same proxy."""
    server = {"public_url": "https://robot.example.org"}
    [hook] = _parse(url, server=server).hook
    assert (hook.events, hook.names) == ([], False)
