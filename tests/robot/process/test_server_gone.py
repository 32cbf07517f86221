"""A server that is gone, frozen or silent: real processes, real signals."""

from __future__ import annotations

import os
import signal
import time
from typing import TYPE_CHECKING

import pytest
from tests.full_pipe import full_pipe
from tests.robot.process.conftest import Log, Server, is_alive, settings_for
from tests.until import until

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = [pytest.mark.system, pytest.mark.alone]

STOP_S = 0.2
"""A safety deadline: silence is 0.12 s here."""


def stands_since(log: Log, stopped_s: float) -> bool:
    time.sleep(0.3)
    return not log.moves(stopped_s)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_server_that_dies_leaves_a_robot_that_stands(
    server: Server, log: Log, number: signal.Signals
) -> None:
    """However a server dies, the robot is stopped at once and closed, and the process ends."""
    server.drive()
    pid = log.pid()
    now_s = time.monotonic()
    os.killpg(server.process.pid, number)  # as a terminal does
    assert log.stopped_s(now_s) - now_s < STOP_S
    server.process.wait()
    until(lambda: not is_alive(pid))
    *_, stop, close = log.entries(now_s)
    assert (stop.word, close.word) == ("stop", "close")
    assert close.at_s - now_s < 1.0


def test_a_frozen_server_stops_the_robot(server: Server, log: Log) -> None:
    """A frozen server's silence stops the robot; afterwards it must first command standstill."""
    server.drive()
    frozen_s = server.signal(signal.SIGSTOP)
    assert log.stopped_s(frozen_s) - frozen_s < STOP_S
    assert stands_since(log, log.stopped_s(frozen_s))
    going_s = server.signal(signal.SIGCONT)
    assert stands_since(log, going_s)
    server.drive()
    assert log.pid() != server.process.pid


def test_a_silent_server_stops_the_robot(server: Server, log: Log) -> None:
    """A server that runs but is silent counts as gone."""
    server.drive()
    silent_s = server.send("silence")
    assert log.stopped_s(silent_s) - silent_s < STOP_S
    assert stands_since(log, log.stopped_s(silent_s))
    server.send("drive")
    assert stands_since(log, log.stopped_s(silent_s))
    server.drive()


def test_an_orderly_end_stops_the_robot(server: Server, log: Log) -> None:
    """`close` returns only after the robot was stopped and closed."""
    server.drive()
    closed_s = server.send("close")
    server.process.wait()
    assert [entry.word for entry in log.entries()][-2:] == ["stop", "close"]
    assert log.stopped_s(closed_s) - closed_s < STOP_S
    assert not is_alive(log.pid())


@pytest.fixture
def unread(log: Log) -> Iterator[Server]:
    """Start a server whose standard error, and that of the driver's process, nobody reads."""
    with full_pipe() as stderr:
        server = Server(settings_for(log), log, stderr=stderr)
        yield server
        server.end()


def test_a_log_that_nobody_reads_does_not_hold_the_process(unread: Server, log: Log) -> None:
    """A full log pipe does not block the driver process."""
    unread.drive()
    pid = log.pid()
    silent_s = unread.send("silence")
    assert stands_since(log, log.stopped_s(silent_s))
    unread.drive()
    closed_s = unread.send("close")
    unread.process.wait()
    assert [entry.word for entry in log.entries(closed_s)][-2:] == ["stop", "close"]
    assert log.pid() == pid
    assert not is_alive(pid)


@pytest.fixture
def patient(log: Log) -> Iterator[Server]:
    """Start a server whose driver process tolerates a second of silence."""
    server = Server(settings_for(log, silence_ms=1000), log)
    yield server
    server.end()


def test_without_the_watchdog_it_would_drive_on(patient: Server, log: Log) -> None:
    """With a limit of a second, a frozen server's robot moves on until that limit stops it."""
    patient.drive()
    frozen_s = patient.signal(signal.SIGSTOP)
    until(lambda: log.moves(frozen_s + 2 * STOP_S))
    assert log.stopped_s(frozen_s) - frozen_s > 2 * STOP_S
