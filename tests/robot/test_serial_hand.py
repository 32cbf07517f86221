"""A hand control on a real pseudo-terminal."""

from __future__ import annotations

import os
import select
import time
import tty
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs

from wax.clock import SystemClock
from wax.config.local import LocalSettings
from wax.driver.hand import HandReading
from wax.robot.hand.line import encode
from wax.robot.hand.serial_hand import SerialHand
from wax.robot.hand.source import RobotsHand

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.system

PATIENCE_S = 10.0


class Line:
    """The control's end of its line."""

    def __init__(self) -> None:
        self.end, other = os.openpty()
        tty.setraw(other)
        self.url = os.ttyname(other)
        self._other: int | None = other
        self._number = 0

    def say(self, *readings: HandReading) -> None:
        data = b""
        for reading in readings:
            self._number += 1
            data += encode(reading, self._number, has_aside=True)
        os.write(self.end, data)

    def pull_out(self) -> None:
        for descriptor in (self.end, self._other):
            if descriptor is not None:
                os.close(descriptor)
        self._other = None


@pytest.fixture
def line() -> Iterator[Line]:
    line = Line()
    yield line
    if line._other is not None:
        line.pull_out()


@pytest.fixture
def hand(line: Line) -> Iterator[SerialHand]:
    hand = opened(line)
    yield hand
    hand.close()


def opened(line: Line) -> SerialHand:
    """Return a reader with an open line; it misses what was sent before."""
    hand = SerialHand(LocalSettings(source="serial", url=line.url), SystemClock())
    end_s = time.monotonic() + PATIENCE_S
    with capture_logs() as logs:
        hand.open()
        while not logs:
            assert time.monotonic() < end_s
            time.sleep(0.005)
    assert [said["log_level"] for said in logs] == ["info"]
    return hand


def wait(hand: SerialHand) -> tuple[HandReading, ...] | None:
    """Wait until the control wakes its reader, and return its readings."""
    end_s = time.monotonic() + PATIENCE_S
    while True:
        assert hand.wakes is not None
        woken, _, _ = select.select([hand.wakes], [], [], PATIENCE_S)
        assert woken
        assert time.monotonic() < end_s
        if (said := hand.take()) != ():
            return said


def test_each_reading_wakes_its_reader(line: Line, hand: SerialHand) -> None:
    """A reading is returned once, with the time at which it was read."""
    line.say(HandReading(0.0, linear=0.5))
    before_s = time.monotonic()
    said = wait(hand)
    assert said is not None
    (reading,) = said
    assert reading.linear == 0.5
    assert before_s - PATIENCE_S < reading.at_s <= time.monotonic()
    assert hand.take() == ()


def test_a_short_press_is_not_lost(line: Line, hand: SerialHand) -> None:
    """If Stop is pressed and released between two polls, both are returned."""
    line.say(HandReading(0.0, stop=True), HandReading(0.0))
    found: list[bool] = []
    while len(found) < 2:
        found += [reading.stop for reading in wait(hand) or ()]
    assert found == [True, False]


def test_a_line_that_is_pulled_out_is_reported(line: Line, hand: SerialHand) -> None:
    """After the last readings, the loss of the line is reported at once."""
    line.say(HandReading(0.0))
    assert wait(hand) is not None
    line.pull_out()
    assert wait(hand) is None


def test_it_closes_twice_and_leaves_nothing_open(line: Line) -> None:
    """No thread and no descriptor is left, as every test checks."""
    hand = opened(line)
    hand.open()
    line.say(HandReading(0.0))
    assert wait(hand) is not None
    hand.close()
    hand.close()
    assert hand.wakes is None


def test_a_robots_own_control_that_fails_is_a_lost_one() -> None:
    """Any exception or invalid reading counts as a lost control, and nothing more."""

    class Robot:
        says: object = None

        def hand(self) -> HandReading | None:
            if isinstance(self.says, Exception):
                raise self.says
            return self.says  # type: ignore[return-value] # a driver may be wrong

    robot = Robot()
    hand = RobotsHand(robot)
    wrong: list[object] = [None, "ahead", OSError("no bus"), HandReading(1.0, linear="ahead")]  # type: ignore[arg-type] # as above
    wrong += [HandReading(1.0, ask="faster")]  # type: ignore[arg-type] # as above
    for one in wrong:
        robot.says = one
        assert hand.take() is None
    robot.says = HandReading(1, stop=1, lateral=-1)  # type: ignore[arg-type] # as above
    assert hand.take() == (HandReading(1.0, stop=True, lateral=-1.0),)
