"""The door's verdicts, step by step; e2e/reach tests the steps themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.door.door_lines import door_line
from tests.door.fake_ssh import Ssh

from wax.commands.doctor import door
from wax.commands.doctor.addresses import local_addresses
from wax.config import settings as config
from wax.config.door import DoorSettings
from wax.door import line
from wax.rtc import relay_check
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from tests.commands.doctor.conftest import MakeNetwork

    from wax.config.settings import Settings
    from wax.door.ssh import Way

LINE = line.read(door_line())
DOOR = DoorSettings(host=LINE.host, port=LINE.port, host_key=LINE.host_key, key_file="key")
CLOSED = Sentence("tunnel.closed", {"host": LINE.host})
TAKEN = Sentence("tunnel.taken", {"host": LINE.host, "port": "20001"})


@pytest.mark.parametrize(
    ("by_22", "by_443", "running", "level"),
    [
        (None, None, False, "ok"),
        (CLOSED, None, False, "warning"),
        (None, CLOSED, False, "warning"),
        (CLOSED, CLOSED, False, "bad"),
        (TAKEN, TAKEN, False, "bad"),
        (TAKEN, TAKEN, True, "ok"),
        (TAKEN, CLOSED, True, "warning"),
    ],
)
def test_the_tunnel_is_tried_by_both_ways(
    by_22: Sentence | None, by_443: Sentence | None, *, running: bool, level: str
) -> None:
    """One way that works is enough; a running server already holds the port."""
    ways: dict[Way, Sentence | None] = {"ssh": by_22, "https": by_443}
    told = door.tunnel(DOOR, running=running, attempt=lambda _, way: ways[way])
    assert told.level == level


def test_a_tunnel_that_says_nothing_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A silent ssh is ended by our own timeout, since macOS has no command for that."""
    started: list[Sequence[str]] = []

    def start(command: Sequence[str]) -> Ssh:
        started.append(command)
        return Ssh()

    (tmp_path / "key").touch()
    monkeypatch.setattr(door, "_TRY_S", 0.01)
    monkeypatch.setattr(door, "start", start)
    told = door.tunnel(DOOR.model_copy(update={"key_file": str(tmp_path / "key")}), running=False)
    assert told.level == "bad"
    assert [command[0] for command in started] == ["ssh", "ssh"]


def settings(**relay: object) -> Settings:
    server = {"public_url": "https://robot.example.org", "trusted_proxies": ["127.0.0.1"]}
    return config.parse({"server": server, "relay": relay, "door": DOOR.model_dump()}, "here")


def test_a_page_that_has_no_server_yet_is_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """Caddy's 502 is ok without a running server, and bad with one."""
    nobody = Sentence("tunnel.page", {"url": "https://x", "why": says("502 Bad Gateway")})
    monkeypatch.setattr(door, "check_page", lambda *_: nobody)
    assert door.page(settings(), 0.0, running=False).level == "ok"
    assert door.page(settings(), 0.0, running=True).level == "bad"
    monkeypatch.setattr(door, "check_page", lambda *_: Sentence("tunnel.clock", {"n": 1440}))
    told = door.page(settings(), 0.0, running=True)
    assert (told.level, "1,440 minutes" in told.sentence) == ("bad", True)


def test_each_address_of_the_relay_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each failing address of the relay is named: some are a warning, all are bad."""
    urls = ["turn:a:3478", "turns:a:5349?transport=tcp"]
    made = settings(urls=urls, secret="s")
    for failing, level in ((0, "ok"), (1, "warning"), (2, "bad")):
        bad = urls[:failing]
        monkeypatch.setattr(
            relay_check, "problem", lambda url, *_, bad=bad: "no" if url in bad else None
        )
        told = door.relay(made, 0.0)
        assert told.level == level
        assert all(url in told.sentence for url in bad)
    assert door.relay(settings(), 0.0).level == "warning"


def test_a_door_is_what_a_shared_address_wants(network: MakeNetwork) -> None:
    """A shared address is a warning without a door, and ok with one."""
    from ipaddress import ip_address  # noqa: PLC0415

    own = [("eth0", ip_address("100.64.0.7"))]
    told = local_addresses(network(), own)
    assert (told.level, "door" in told.advice) == ("warning", True)
    assert local_addresses(network(door="robot.example.org"), own).level == "ok"


def test_without_a_door_there_is_nothing_to_check() -> None:
    """Without a door there are no checks."""
    assert door.checks(config.load(None), 0.0, running=False) == []
