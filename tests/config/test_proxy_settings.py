"""`[access.proxy]`: what would believe strangers is refused at the start."""

from __future__ import annotations

import re
import textwrap
import tomllib
from pathlib import Path
from typing import Any, Final

import pytest
from tests.door.door_lines import door_line

from wax.config import settings as config
from wax.config.proxy import doubts
from wax.door import line
from wax.errors import ConfigError

TEXT: Final = (Path(__file__).parents[2] / "config/deploy/README.md").read_text(encoding="utf-8")
RECIPES: Final = [
    tomllib.loads(textwrap.dedent(block))["access"]["proxy"]
    for block in re.findall(r"^((?:    .*\n)+)", TEXT, re.MULTILINE)
    if "[access.proxy]" in block
]

LINE = line.read(door_line())
DOOR = {"host": LINE.host, "port": LINE.port, "host_key": LINE.host_key, "key_file": "key"}
HERE = ["127.0.0.1", "::1"]
BY_GROUPS = {"person": "Remote-User", "groups": "Remote-Groups", "host": ["staff"]}


def parse(proxy: dict[str, Any], trusted: list[str], **tables: dict[str, Any]) -> config.Settings:
    server = {"trusted_proxies": trusted} | tables.pop("server", {})
    return config.parse({"access": {"proxy": proxy}, "server": server, **tables}, "here")


def test_it_is_off_by_default() -> None:
    """Nobody is believed by a header unless the host names it."""
    assert not config.load(None).access.proxy.is_used
    assert parse(BY_GROUPS | {"host_link": False}, HERE).access.proxy.is_used


@pytest.mark.parametrize(
    ("proxy", "trusted", "why"),
    [
        (
            {"person": "Remote-User"},
            [],
            r'name its address in \[server\] trusted_proxies, as \["127',
        ),
        ({"person": "Remote-User"}, ["0.0.0.0/0"], "0.0.0.0/0, where strangers are"),
        ({"person": "Remote-User"}, ["127.0.0.1", "::/0"], "::/0, where strangers are"),
        (
            {"person": "Remote-User"},
            ["203.0.113.0/24", "198.51.101.0/24"],
            "198.51.101.0/24, where",
        ),
        ({"person": "Remote_User"}, HERE, "no header's name"),
        ({"person": "Remote-User:"}, HERE, "no header's name"),
        ({"name": "Remote-Name"}, HERE, "person is missing"),
        ({"person": "Remote-User", "drive": ["pupils"]}, HERE, "groups is missing"),
        ({"person": "Remote-User", "host_link": False}, HERE, "nobody could be host"),
        (BY_GROUPS | {"host": ["a,b"]}, HERE, "without , and"),
    ],
)
def test_strangers_are_never_believed(proxy: dict[str, Any], trusted: list[str], why: str) -> None:
    """Without a trusted proxy of its own, or where nobody could come in, it says what to do."""
    with pytest.raises(ConfigError, match=why):
        parse(proxy, trusted)


def test_a_door_hands_on_what_strangers_write() -> None:
    """A door's visitors come from this machine as a proxy does, so it cannot be beside one."""
    with pytest.raises(ConfigError, match=r"leave \[door\] or \[access.proxy\] out"):
        parse(BY_GROUPS, HERE, door=DOOR)


@pytest.mark.parametrize(
    ("trusted", "host", "told"),
    [
        (HERE, "localhost", []),
        (["127.0.0.0/8"], "localhost", []),
        (["10.9.0.1"], "10.9.0.2", []),
        (["10.9.0.0/24"], "10.9.0.2", ["Every machine in 10.9.0.0/24 is believed"]),
        (HERE, "0.0.0.0", ["comes past the proxy"]),
    ],
)
def test_what_may_be_meant_is_doubted(trusted: list[str], host: str, told: list[str]) -> None:
    """A wide network of proxies, and a port that is open beside them, are named to the host."""
    settings = parse(BY_GROUPS, trusted, server={"host": host})
    found = doubts(settings.access.proxy, settings.server)
    assert len(found) == len(told)
    assert all(one in what for one, (what, _) in zip(told, found, strict=True))


@pytest.mark.parametrize("proxy", RECIPES, ids=lambda proxy: proxy.get("token", proxy["person"]))
def test_a_recipe_loads_as_it_is_written(proxy: dict[str, Any]) -> None:
    """Each proxy of the hosting manual is accepted, and only one that signs goes through a door."""
    assert parse(proxy, HERE).access.proxy.is_used
    if "token" in proxy:
        assert parse(proxy, HERE, door=DOOR).access.proxy.token


TOKEN = {
    "person": "email",
    "token": "Cf-Access-Jwt-Assertion",
    "keys": "https://id.example/certs",
    "issuer": "https://id.example",
    "audience": "robot",
}


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"audience": ""}, "audience missing: token, keys, issuer and audience belong together"),
        ({"issuer": "", "keys": ""}, "keys and issuer missing"),
        ({"token": ""}, "token is missing"),
        ({"keys": "http://id.example/certs"}, "a file, or an address"),
        ({"keys": "https://me@id.example/"}, "a file, or an address"),
        ({"person": ""}, "person is missing"),
    ],
)
def test_a_token_is_checked_whole_or_not_at_all(changed: dict[str, str], why: str) -> None:
    """Whose, for whom and by which keys it is must be said, and keys come by a way that is safe."""
    assert parse(TOKEN, HERE).access.proxy.is_used
    with pytest.raises(ConfigError, match=why):
        parse(TOKEN | changed, HERE)
