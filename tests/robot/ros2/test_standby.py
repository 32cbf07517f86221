"""What the standby reports to the driver and sends to the robot, on a link of this process."""

from __future__ import annotations

import os
import threading
import time
from typing import TYPE_CHECKING

import pytest
from tests.robot.ros2.robots import ros2_settings

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.errors import DriverError
from wax.robot.ros2 import standby as module
from wax.robot.ros2.command_topic import Traffic
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby import Standby
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ZEROS_S = 0.05


class Played:
    """A standby in a thread, between two pipes; while it is `cut`, its link raises."""

    guid = "me"

    def __init__(self) -> None:
        self.cut = False
        self.reaches: int | None = 1
        self.told: list[Twist] = []
        own = ros2_settings(0).own(Ros2Settings).model_copy(update={"zeros_s": ZEROS_S})
        reader, self._words = os.pipe()
        self._heard, self.writer = os.pipe()
        for end in (self._heard, self.writer):
            os.set_blocking(end, False)
        self._ends = {reader, self._words, self._heard, self.writer}
        self._thread = threading.Thread(
            target=Standby(own, SystemClock(), reader, self.writer).run, daemon=True
        )

    def start(self) -> None:
        self._thread.start()

    def end_driver(self) -> None:
        """Close the pipe as a killed driver does, and wait for the standby's end."""
        if self._words in self._ends:
            self._ends.remove(self._words)
            os.close(self._words)
        self._thread.join(5)
        assert not self._thread.is_alive()

    def close_pipes(self) -> None:
        for end in self._ends:
            os.close(end)

    def lines(self, enough: Callable[[list[str]], bool]) -> list[str]:
        """Return the lines that the driver receives from now on, once `enough` holds."""
        heard = b""
        end_s = time.monotonic() + 5.0
        while not enough(heard.decode().splitlines()):
            assert time.monotonic() < end_s, heard
            time.sleep(0.002)
            try:
                heard += os.read(self._heard, 65_536)
            except BlockingIOError:
                continue
        return heard.decode().splitlines()

    # --- as its link ---------------------------------------------------------------------------

    def open(self, *_: object, **__: object) -> Played:
        self._fail_if_cut()
        return self

    def send(self, twist: Twist, _: int) -> None:
        self._fail_if_cut()
        self.told.append(twist)

    def traffic(self) -> Traffic:
        self._fail_if_cut()
        return Traffic(matched=self.reaches)

    def close(self) -> None:
        """Nothing is held."""

    def _fail_if_cut(self) -> None:
        if self.cut:
            raise DriverError(Sentence("robot.no_answer"))


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Iterator[Played]:
    played = Played()
    monkeypatch.setattr(module, "open_link", played.open)
    monkeypatch.setattr(module, "LOOK_S", 0.01)
    played.start()
    yield played
    played.cut = False
    played.end_driver()
    played.close_pipes()


def test_it_reports_at_every_check_that_it_is_there(played: Played) -> None:
    """An unchanged report is repeated; by rosbridge the number is unknown."""
    assert set(played.lines(lambda lines: len(lines) >= 5)) == {"me 1"}
    played.reaches = None
    assert "me -" in played.lines(lambda lines: lines[-2:] == ["me -"] * 2)


def test_it_reports_that_it_has_lost_the_robot(played: Played) -> None:
    """After a failure it reports at each failed attempt that it reaches nobody."""
    played.lines(lambda lines: len(lines) >= 2)
    played.cut = True
    played.lines(lambda lines: lines[-3:] == ["- 0"] * 3)
    played.cut = False
    played.lines(lambda lines: lines[-1:] == ["me 1"])
    assert played.told == []


def test_a_driver_that_reads_nothing_does_not_freeze_it(played: Played) -> None:
    """Even with a full pipe to the driver, standstill is sent when the driver ends."""
    played.lines(lambda lines: len(lines) >= 2)
    while True:
        try:
            os.write(played.writer, b"\n" * 4096)
        except BlockingIOError:
            break
    time.sleep(0.05)
    played.end_driver()
    assert set(played.told) == {STANDSTILL}
