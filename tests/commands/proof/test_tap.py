"""The tap on a real pseudo-terminal in place of the robot's port."""

from __future__ import annotations

import os
import pty
import select
import time
import tty
from typing import TYPE_CHECKING

import pytest

from wax.commands.proof.line_decoder import language_of
from wax.commands.proof.tap import Tap
from wax.config.serial import SerialSettings
from wax.errors import DriverError
from wax.robot.serial.frames import (
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    ReportBody,
    StopBody,
    encode,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

pytestmark = pytest.mark.system

SESSION = 77
HELLO = encode(Frame(HelloBody(SESSION)), SESSION)
DRIVE = encode(Frame(DriveBody(180, 180), sequence=1), SESSION)
STOP = encode(Frame(StopBody(), sequence=2), SESSION)
MOVES = encode(Frame(ReportBody(0, 0, 0, 0, 1, 1)), SESSION)
STANDS = encode(Frame(ReportBody(0, 0, 0, 0, 0, 2)), SESSION)


class Ends:
    """The robot's end of its line and, once opened, the server's end of ours."""

    def __init__(self) -> None:
        self.robot, self.port = pty.openpty()
        tty.setraw(self.port)
        settings = SerialSettings(url=os.ttyname(self.port))
        self.tap = Tap(settings, language_of(settings))
        self.server: int | None = None

    def open(self) -> int:
        self.tap.open()
        self.server = os.open(self.tap.path, os.O_RDWR | os.O_NOCTTY)
        return self.server

    def close(self) -> None:
        self.tap.close()
        for end in (self.robot, self.port, self.server):
            if end is not None:
                os.close(end)


@pytest.fixture
def ends() -> Iterator[Ends]:
    both = Ends()
    yield both
    both.close()


def read(end: int, length: int, within_s: float = 5.0) -> bytes:
    """Return `length` bytes, or fewer after `within_s`."""
    data = b""
    end_s = time.monotonic() + within_s
    while len(data) < length and time.monotonic() < end_s:
        if select.select([end], [], [], 0.05)[0]:
            data += os.read(end, length - len(data))
    return data


def becomes(ask: Callable[[], bool]) -> bool:
    end_s = time.monotonic() + 5.0
    while time.monotonic() < end_s:
        if ask():
            return True
        time.sleep(0.01)
    return False


def test_bytes_pass_both_ways_and_are_noted(ends: Ends) -> None:
    """Bytes pass unchanged in both directions, and are recorded as events."""
    server = ends.open()
    os.write(server, HELLO + DRIVE)
    assert read(ends.robot, len(HELLO + DRIVE)) == HELLO + DRIVE
    os.write(ends.robot, MOVES)
    assert read(server, len(MOVES)) == MOVES
    assert becomes(ends.tap.moves)
    assert [(event.who, event.moves) for event in ends.tap.events()] == [
        ("said", False),
        ("said", True),
        ("told", True),
    ]
    ends.tap.forget()
    assert ends.tap.events() == []


def test_a_cut_line_carries_nothing_but_is_still_heard(ends: Ends) -> None:
    """While cut, no byte passes, but the robot's reports are recorded; mended, they pass again."""
    server = ends.open()
    os.write(server, HELLO + DRIVE)
    read(ends.robot, len(HELLO + DRIVE))
    ends.tap.cut()
    os.write(server, DRIVE)
    os.write(ends.robot, MOVES)
    assert becomes(ends.tap.moves)
    assert read(ends.robot, 1, within_s=0.2) == b""
    assert read(server, 1, within_s=0.2) == b""
    assert becomes(lambda: not select.select([ends.tap._ours], [], [], 0)[0])  # it was taken
    ends.tap.mend()
    os.write(server, STOP)
    assert read(ends.robot, len(STOP)) == STOP
    assert ends.tap.events()[-1].moves is False


def test_closed_it_leaves_a_robot_that_was_told_to_stand(ends: Ends) -> None:
    """Closing sends the robot a valid stop last, whatever the server still sends."""
    server = ends.open()
    robot = Decoder()
    os.write(server, HELLO + DRIVE)
    assert len(robot.feed(read(ends.robot, len(HELLO + DRIVE)))) == 2
    ends.tap.close()
    heard = robot.feed(read(ends.robot, 4096, within_s=0.3))
    assert {type(frame.body) for frame in heard} == {HelloBody, StopBody}
    ends.tap.close()


def test_a_robot_that_reports_standstill_does_not_move(ends: Ends) -> None:
    """The robot's newest report decides whether it moves, not its last command."""
    server = ends.open()
    os.write(server, HELLO + DRIVE)
    read(ends.robot, len(HELLO + DRIVE))
    os.write(ends.robot, MOVES + STANDS)
    assert becomes(lambda: len(ends.tap.events()) == 4)
    assert not ends.tap.moves()


def test_a_port_that_is_in_use_is_a_sentence(ends: Ends) -> None:
    """A second tap on a port is refused with a sentence that says what to do."""
    ends.open()
    with pytest.raises(DriverError, match="end the program"):
        Ends.open(_Second(ends))


def test_a_port_that_is_lost_is_a_sentence(ends: Ends) -> None:
    """A lost port raises at the next call of `events`, and `close` still works."""
    ends.open()
    os.close(ends.robot)
    os.close(ends.port)
    ends.robot = ends.port = os.open(os.devnull, os.O_RDONLY)
    ends.port = os.dup(ends.robot)

    def lost() -> bool:
        try:
            ends.tap.events()
        except DriverError as error:
            return "was lost" in str(error)
        return False

    assert becomes(lost)


class _Second(Ends):
    """A second tap on the same port."""

    def __init__(self, first: Ends) -> None:
        settings = SerialSettings(url=os.ttyname(first.port))
        self.tap = Tap(settings, language_of(settings))
