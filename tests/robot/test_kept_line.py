"""How a line is kept open, whatever it is made of."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, ClassVar

import pytest
from tests.until import until

from wax.clock import SystemClock
from wax.robot.line import kept_line
from wax.robot.line.kept_line import KeptLine, RobotLine
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Recorded(RobotLine):
    """Writes down its calls; the one named in `failing` raises, `gate` makes opening wait."""

    hears: ClassVar[bool] = True

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.failing = ""
        self.leaves_s = 0.0
        self.pause_s = 0.01
        self.gate = threading.Event()
        self.gate.set()

    def call(self, name: str) -> None:
        self.calls.append(name)
        if name == self.failing:
            raise OSError(name)

    def start(self) -> None:
        self.call("start")

    def open(self, wake: Callable[[], None]) -> None:
        self.gate.wait()
        self.call("open")

    def begin(self, now_s: float) -> None:
        self.call("begin")

    def step(self, now_s: float) -> float:
        self.call("step")
        return now_s + self.pause_s

    def hear(self) -> bool:
        threading.Event().wait(0.002)
        if self.failing == "hear":
            raise OSError("hear")
        return False

    def leave(self, now_s: float) -> float:
        self.call("leave")
        return self.leaves_s

    def last_words(self, error: Exception) -> None:
        self.call(f"last words after {error}")

    def close(self) -> None:
        self.call("close")

    def end(self) -> None:
        self.call("end")

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:
        return Sentence("robot.not_reached", {"why": f"{error} {was_open}"})

    def lost(self, problem: Sentence | None) -> None:
        self.calls.append(f"lost {problem and problem.values['why']}")


@pytest.fixture
def line() -> Recorded:
    return Recorded()


@pytest.fixture
def kept(line: Recorded) -> Iterator[KeptLine]:
    kept = KeptLine("line", line, line, SystemClock(), reopen_s=0.01, close_s=0.5)
    yield kept
    line.gate.set()
    kept.close()


@pytest.mark.parametrize("failing", ["step", "hear"])
def test_a_line_that_fails_says_its_last_words_and_is_reopened(
    line: Recorded, kept: KeptLine, failing: str
) -> None:
    """Whichever direction is lost, the other may still stop the robot."""
    kept.open()
    until(lambda: "step" in line.calls)
    line.failing = failing
    until(lambda: line.calls.count("open") > 1)
    after = line.calls[line.calls.index(f"last words after {failing}") :]
    assert after[1:4] == ["close", f"lost {failing} True", "open"]
    assert line.calls.count("start") == 1


def test_a_line_that_does_not_open_is_tried_again(line: Recorded, kept: KeptLine) -> None:
    """It has nothing to close, and no last words."""
    line.failing = "open"
    kept.open()
    until(lambda: line.calls.count("lost open False") > 1)
    assert set(line.calls) == {"start", "open", "lost open False"}


def test_a_deaf_line_is_left_as_slowly_as_any(line: Recorded, kept: KeptLine) -> None:
    """A reader that fails does not cut the farewell short; nothing is sent after it."""
    line.leaves_s = 0.1
    kept.open()
    until(lambda: "step" in line.calls)
    line.call = lambda name: _fail_after(line, name)  # type: ignore[method-assign]
    kept.close()
    after = line.calls[line.calls.index("leave") + 1 :]
    assert after.count("step") > 2
    assert after[-4:] == ["close", "lost None", "end", "lost None"]
    assert not any("last words" in call for call in after)


def _fail_after(line: Recorded, name: str) -> None:
    line.calls.append(name)
    if name == "leave":
        line.failing = "hear"


def test_a_second_thread_waits_for_the_one_that_hangs(line: Recorded, kept: KeptLine) -> None:
    """Two threads never talk to one robot."""
    line.gate.clear()
    kept.open()
    kept.close()
    kept.open()
    assert line.calls == ["start", "lost None"]
    line.gate.set()
    until(lambda: line.calls.count("step") > 1)
    assert line.calls.index("end") < line.calls.index("start", 1)


def test_what_the_reader_lost_before_the_first_step_is_told_at_once(
    line: Recorded, kept: KeptLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A peer that accepts and closes is noticed, though no set-point is due for long."""
    monkeypatch.setattr(kept_line, "LONGEST_PAUSE_S", 60.0)
    clear = kept._news.clear

    def clear_late() -> None:
        until(lambda: kept._error)
        clear()

    monkeypatch.setattr(kept._news, "clear", clear_late)
    line.failing, line.pause_s = "hear", 60.0
    kept.open()
    until(lambda: "lost hear True" in line.calls)
