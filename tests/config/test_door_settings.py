"""`[door]`: complete or absent, and with server settings that fit it."""

from __future__ import annotations

from typing import Any

import pytest
from tests.door.door_lines import door_line

from wax.config import settings as config
from wax.door import line
from wax.errors import ConfigError

LINE = line.read(door_line())
DOOR = {"host": LINE.host, "port": LINE.port, "host_key": LINE.host_key, "key_file": "key"}
PROXIES = {"trusted_proxies": ["127.0.0.1", "::1"]}


def test_a_door_may_be_there_or_not() -> None:
    """A complete door is accepted; there is none by default, so no outside host is contacted."""
    assert not config.load(None).door.host
    settings = config.parse({"door": DOOR, "server": PROXIES}, "here")
    assert settings.door.host_key == LINE.host_key


@pytest.mark.parametrize(
    ("door", "server", "why"),
    [
        ({"port": 0}, PROXIES, "port missing"),
        ({"host_key": "", "key_file": ""}, PROXIES, "host_key and key_file missing"),
        ({"host_key": "ssh-rsa AAAA"}, PROXIES, "ssh-ed25519"),
        ({"host": "-oProxyCommand=x"}, PROXIES, "a host name or address"),
        ({}, {}, "one address's limits"),
        ({}, PROXIES | {"https": True}, "leave https and certificate out"),
        ({}, PROXIES | {"certificate": "a", "key": "b"}, "leave https and certificate out"),
    ],
)
def test_half_a_door_is_none(door: dict[str, Any], server: dict[str, Any], why: str) -> None:
    """A door that would not work, or could run a foreign program, is refused at the start."""
    with pytest.raises(ConfigError, match=why):
        config.parse({"door": DOOR | door, "server": server}, "here")
