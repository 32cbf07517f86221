"""A person aboard and a real driver process, with a server that runs, freezes or dies."""

from __future__ import annotations

import os
import signal
import time
from typing import TYPE_CHECKING, Any

import psutil
import pytest
from structlog.testing import capture_logs
from tests.robot.process.conftest import Log, Server, is_alive, settings_for
from tests.until import until

from wax.config.local import LocalSettings
from wax.robot.process.passenger_claim import Claim
from wax.robot.process.stop_mark import StopMark

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

pytestmark = pytest.mark.system

LOCAL = LocalSettings(source="robot", pause_s=0.5, max_fraction=1.0)


class Person:
    """A person whose control is a file that `tests.robot.process.recorder.Seated` reads."""

    def __init__(self, log: Log) -> None:
        self._path = log._path.with_suffix(".hand")
        self.does("0 0 -")

    def does(self, what: str) -> float:
        """Do something; return when."""
        new = self._path.with_suffix(".new")
        new.write_text(what)
        now_s = time.monotonic()
        new.replace(self._path)
        return now_s

    def pulls_the_plug(self) -> float:
        now_s = time.monotonic()
        self._path.unlink()
        return now_s


@pytest.fixture
def person(log: Log) -> Person:
    return Person(log)


@pytest.fixture
def start(log: Log, tmp_path: Path, person: Person) -> Iterator[Callable[..., Server]]:
    """Start servers for one robot, and end them and any surviving processes."""
    servers: list[Server] = []

    def start(**local: Any) -> Server:
        settings = settings_for(log, "Seated")
        claim = str(tmp_path / "state" / "driver-claim")
        rules = LOCAL.model_copy(update=local)
        servers.append(Server(settings, log, local=rules, claim=claim))
        return servers[-1]

    yield start
    left = {int(entry.values[0]) for entry in log.entries() if entry.word == "open"}
    for server in servers:
        if server.process.poll() is None:
            left |= {child.pid for child in psutil.Process(server.process.pid).children()}
        server.end()
    for pid in left:
        if is_alive(pid):
            os.kill(pid, signal.SIGKILL)


def backward(log: Log, since_s: float) -> bool:
    """Whether the person's own set-point has reached the robot; the server's goes ahead."""
    return any(e.word == "apply" and e.values[0] < 0.0 for e in log.entries(since_s))


def ahead_after(log: Log, since_s: float) -> list[float]:
    return [e.at_s for e in log.entries(since_s) if e.word == "apply" and e.values[0] > 0.0]


def is_replaced(log: Log, old: int) -> Callable[[], bool]:
    return lambda: log.pid() != old


def test_a_person_outranks_a_server_that_drives(
    start: Callable[..., Server], log: Log, person: Person
) -> None:
    """Without their control nobody drives; with it a touch stops the robot, which is then theirs.

    Switching the server off still ends its process, since then nobody holds the robot.
    """
    server = start()
    server.drive()
    stopped_s = log.stopped_s(person.pulls_the_plug())
    time.sleep(0.3)
    assert not log.moves(stopped_s)
    person.does("0 0 -")
    server.drive()
    touched_s = person.does("-1 0 -")
    stopped_s = log.stopped_s(touched_s)
    until(lambda: backward(log, touched_s))
    assert ahead_after(log, stopped_s) == []
    server.send("close")
    until(lambda: not is_alive(log.pid()))
    assert server.process.wait(5.0) == 0


@pytest.mark.parametrize("how", [signal.SIGSTOP, signal.SIGKILL])
def test_the_person_drives_and_stops_without_the_server(
    start: Callable[..., Server], log: Log, person: Person, how: signal.Signals
) -> None:
    """With a frozen or dead server the person can still take over, drive and stop."""
    server = start()
    server.drive()
    gone_s = server.signal(how)
    log.stopped_s(gone_s)
    touched_s = person.does("-1 0 -")
    until(lambda: backward(log, touched_s))
    later_s = time.monotonic() + 0.5
    until(lambda: backward(log, later_s))
    stop_s = person.does("-1 0 stop")
    stopped_s = log.stopped_s(stop_s)
    time.sleep(0.2)
    assert not log.moves(stopped_s)
    assert is_alive(log.pid())


def test_a_stop_of_theirs_outlives_whatever_dies(
    start: Callable[..., Server], log: Log, person: Person, tmp_path: Path
) -> None:
    """The person's Stop survives the process and the server; only the person releases it."""
    server = start()
    server.drive()
    log.stopped_s(person.does("0 0 stop"))
    until(lambda: StopMark(tmp_path / "state" / "driver-claim.stopped").is_set)
    person.does("0 0 -")
    for dies in ("process", "server"):
        old = log.pid()
        if dies == "process":
            os.kill(old, signal.SIGKILL)
        else:
            server.signal(signal.SIGKILL)
            server = start()
        until(is_replaced(log, old))
        began_s = time.monotonic()
        for _ in range(4):  # for longer than the pause
            server.send("stand")
            time.sleep(0.1)
            server.send("drive")
            time.sleep(0.1)
        assert not log.moves(began_s), f"the {dies} has died"
    person.does("0 0 go_on")
    server.drive()


def test_a_sharing_stick_drives_only_without_an_operator(
    start: Callable[..., Server], log: Log, person: Person
) -> None:
    """A shared stick drives only while set-points say that there is no operator."""
    server = start(stick="shares")
    until(lambda: any(entry.word == "apply" for entry in log.entries()))
    time.sleep(LOCAL.pause_s + 0.3)
    touched_s = person.does("-1 0 -")
    time.sleep(0.3)
    assert not log.moves(touched_s)
    person.does("0 0 -")
    left_s = server.send("leave")

    def drives() -> bool:
        """Let go and push again, each for long enough to be felt, as a person does."""
        person.does("0 0 -")
        time.sleep(0.1)
        person.does("-1 0 -")
        time.sleep(0.1)
        return backward(log, left_s)

    until(drives)


def test_the_next_server_takes_over_when_no_hand_is_on(
    start: Callable[..., Server], log: Log, person: Person, tmp_path: Path
) -> None:
    """The next server's process opens the robot only after the old one was released and ended."""
    first = start()
    first.drive()
    old = log.pid()
    log.stopped_s(first.signal(signal.SIGKILL))
    person.does("-1 0 -")
    mark = (tmp_path / "state" / "driver-claim").read_text()
    second = start()
    until(lambda: (tmp_path / "state" / "driver-claim").read_text() != mark)
    began_s = time.monotonic() + 0.3
    until(lambda: backward(log, began_s))
    assert log.pid() == old
    person.does("0 0 -")
    until(lambda: not is_alive(old))
    second.drive()


def test_a_server_that_fails_leaves_the_robot_to_the_person(
    start: Callable[..., Server], log: Log, person: Person
) -> None:
    """A server that ends because of a failure counts as dead, and the person drives on."""
    server = start()
    server.drive()
    server.send("abandon")
    assert server.process.wait(5.0) == 0
    touched_s = person.does("-1 0 -")
    until(lambda: backward(log, touched_s))
    assert is_alive(log.pid())


def test_a_claim_is_held_until_another_takes_it(tmp_path: Path) -> None:
    """The newest mark holds the claim; a deleted file changes nothing."""
    path = tmp_path / "state" / "driver-claim"
    old, new = Claim(path), Claim(path)
    assert not old.is_held
    old.take()
    assert old.is_held
    new.take()
    assert (old.is_held, new.is_held) == (False, True)
    path.unlink()
    assert new.is_held


def test_only_one_has_the_robot(tmp_path: Path) -> None:
    """The process that has the robot keeps it until it ends, whatever the marks say."""
    path = tmp_path / "driver-claim"
    old, new = Claim(path), Claim(path)
    old.take()
    assert old.has_robot()
    new.take()
    assert not new.has_robot()
    assert old.has_robot()


def test_without_a_file_to_mark_nothing_is_claimed(tmp_path: Path) -> None:
    """If the mark cannot be written, the process ends with its server."""
    (tmp_path / "file").write_text("")
    claim = Claim(tmp_path / "file" / "driver-claim")
    claim.take()
    assert not claim.is_held


def test_a_stop_is_kept_for_the_next_process(tmp_path: Path) -> None:
    """The Stop's file exists exactly while the Stop is in force."""
    path = tmp_path / "claim.stopped"
    mark = StopMark(path)
    assert not StopMark(path).is_set
    mark.keep(False)
    assert not StopMark(path).is_set
    mark.keep(True)
    mark.keep(True)
    assert StopMark(path).is_set
    StopMark(path).keep(False)
    assert not mark.is_set


def test_a_stop_that_cannot_be_kept_is_told_of(tmp_path: Path) -> None:
    """A Stop that cannot be saved is logged once, and has no other effect."""
    (tmp_path / "file").write_text("")
    mark = StopMark(tmp_path / "file" / "claim.stopped")
    with capture_logs() as logs:
        mark.keep(True)
        mark.keep(True)
    assert not mark.is_set
    assert [said["log_level"] for said in logs] == ["warning"]
