"""The tunnel's threads, with a fake ssh whose messages come from a pipe."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import pytest
from tests.door.door_lines import door_line
from tests.door.fake_ssh import WITHIN_S, Ssh
from tests.turned_clock import TurnedClock

from wax.config import settings as config
from wax.door import line, tunnel
from wax.door.tunnel import Tunnel
from wax.rtc.stun_query import StunError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

OPENED = b"debug1: remote forward success for: listen 127.0.0.1:20001, connect 127.0.0.1:8080\n"


class Stage:
    """A tunnel that starts fakes of ssh, and keeps them."""

    def __init__(self, folder: Path) -> None:
        self.commands: list[Sequence[str]] = []
        self.started: list[Ssh] = []
        self._news = threading.Condition()
        door = line.read(door_line())
        (folder / "key").touch()
        self.settings = config.parse(
            {
                "server": {
                    "trusted_proxies": ["127.0.0.1"],
                    "state_dir": str(folder),
                    "public_url": f"https://{door.host}",
                },
                "network": {"stun": ["stun:stun.example:1", f"stun:{door.host}:3478"]},
                "door": {
                    "host": door.host,
                    "port": door.port,
                    "host_key": door.host_key,
                    "key_file": str(folder / "key"),
                },
            },
            "here",
        )
        self.clock = TurnedClock()
        self.tunnel = Tunnel(self.settings, self.clock, lambda: 8080, self._run)

    def _run(self, command: Sequence[str]) -> Any:
        with self._news:
            self.commands.append(command)
            self.started.append(Ssh())
            self._news.notify_all()
            return self.started[-1]

    def ssh(self, number: int) -> Ssh:
        """Wait for the n-th start of ssh and return its fake."""
        with self._news:
            assert self._news.wait_for(lambda: len(self.started) >= number, WITHIN_S)
        return self.started[number - 1]

    def until(self, code: str | None) -> None:
        """Wait until this is the only problem shown to the host, or until there is none."""
        for _ in range(int(WITHIN_S * 100)):
            problems = self.tunnel.problems()
            if [one.code for one in problems] == ([] if code is None else [code]):
                return
            threading.Event().wait(0.01)
        raise AssertionError(f"{self.tunnel.problems()}, not {code}")


@pytest.fixture
def stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stage]:
    for name in ("check_page", "public_address"):  # page and relay work
        monkeypatch.setattr(tunnel, name, lambda *_: None)
    made = Stage(tmp_path)
    yield made
    made.tunnel.stop()


def is_open(stage: Stage) -> bool:
    return bool((stage.tunnel.status() or {})["is_open"])


def test_the_host_reads_why_the_door_does_not_lead_here_and_when_it_does(stage: Stage) -> None:
    """The host sees the tunnel refused, retried, opened, stalled and reopened."""
    assert stage.tunnel.problem is None
    stage.tunnel.start()
    stage.ssh(1).ends(b"ssh: connect to host robot.example.org port 22: Connection refused\n")
    stage.until("tunnel.closed")
    stage.ssh(2).says(OPENED)
    stage.until(None)
    assert is_open(stage)
    stage.clock.time_s += 60
    stage.ssh(2).ends(b"Timeout, server robot.example.org not responding.\n")
    stage.until("tunnel.stalled")
    assert not is_open(stage)
    stage.ssh(3).says(OPENED)
    stage.until(None)
    status = stage.tunnel.status() or {}
    assert (status["opened"], status["failed"]) == (2, 2)


@pytest.mark.parametrize(
    "words",
    [
        b"debug1: remote software version remote forward success for: listen 127.0.0.1:20001\n",
        b"no matching host key type found. Their offer: ".ljust(2000) + OPENED,
    ],
)
def test_a_stranger_on_the_way_opens_nothing(stage: Stage, words: bytes) -> None:
    """Only ssh's own line says that the tunnel is open, not a stranger's text that it quotes."""
    stage.tunnel.start()
    stage.ssh(1).says(words)
    stage.ssh(1).ends(b"Host key verification failed.\n")
    stage.until("tunnel.host_key")
    assert (stage.tunnel.status() or {})["opened"] == 0


def test_22_is_followed_by_https(stage: Stage) -> None:
    """The second attempt uses our ProxyCommand, which speaks HTTPS to the door."""
    stage.tunnel.start()
    stage.ssh(1).ends()
    stage.ssh(2)
    assert not any("ProxyCommand" in word for word in stage.commands[0])
    [proxy] = [word for word in stage.commands[1] if "ProxyCommand" in word]
    assert proxy.endswith("wax.door.over_https robot.example.org")


def test_the_end_ends_ssh_and_starts_none(stage: Stage) -> None:
    """Stopping ends the running ssh and starts no other."""
    stage.tunnel.start()
    stage.ssh(1).says(OPENED)
    stage.until(None)
    stage.tunnel.request_stop()
    stage.tunnel.stop()
    assert len(stage.started) == 1
    assert not [one for one in threading.enumerate() if one.name == "tunnel"]


def test_a_folder_that_cannot_be_written_is_told(stage: Stage, tmp_path: Path) -> None:
    """If the pinned key cannot be written, ssh is not started and the host is told."""
    (tmp_path / "door_known_hosts").mkdir()
    stage.tunnel.start()
    stage.until("tunnel.failed")
    assert not stage.started


def test_a_door_without_its_relay_is_told_to_the_host_alone(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A dead relay is a problem for the host only: the page opens, but some viewers see nothing."""
    asked: list[str] = []

    def ask(server: str) -> str:
        asked.append(server)
        raise StunError("it does not answer")

    monkeypatch.setattr(tunnel, "_FIRST_CHECK_S", 0.01)
    monkeypatch.setattr(tunnel, "public_address", ask)
    stage.tunnel.start()
    stage.ssh(1).says(OPENED)
    stage.until("tunnel.no_relay")
    assert stage.tunnel.problem is None
    assert asked == ["robot.example.org:3478"]


def test_without_a_door_nothing_is_started() -> None:
    """Without a door, no thread is started and no problem is reported."""
    tunnel = Tunnel(config.load(None), TurnedClock(), lambda: 8080)
    tunnel.start()
    assert (tunnel.status(), tunnel.problems()) == (None, [])
    tunnel.stop()
