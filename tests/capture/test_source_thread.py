"""The source thread reports, closes and reopens a failing source, and ends when told."""

from __future__ import annotations

import queue
import threading
from time import monotonic
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.turned_clock import TurnedClock

from wax import device_thread
from wax.capture.source_thread import SourceThread
from wax.errors import SourceError
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Callable

WAIT_S = 5.0
"""How long a test waits for a thread before it fails; never slept away."""


class Script:
    """A source whose every step the test supplies."""

    def __init__(self) -> None:
        self.steps: queue.Queue[int | Exception] = queue.Queue()
        self.reading = threading.Event()
        self.released = threading.Event()
        self.opened = 0
        self.closed = 0
        self.open_error: Exception | None = None

    def open(self) -> None:
        self.opened += 1
        if self.open_error is not None:
            raise self.open_error

    def read(self) -> int:
        self.reading.set()
        step = self.steps.get(timeout=WAIT_S)
        if isinstance(step, Exception):
            raise step
        return step

    def close(self) -> None:
        self.closed += 1
        self.released.set()


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_thread, "_RETRY_S", 0.001)


class RestingScript(Script):
    """A source that may be left unread."""

    def __init__(self, rest_s: float) -> None:
        super().__init__()
        self.rest_s = rest_s


class Need(threading.Event):
    """Tells when a rest begins, and how long it may be."""

    def __init__(self) -> None:
        super().__init__()
        self.rests_s: queue.Queue[float | None] = queue.Queue()

    def wait(self, timeout: float | None = None) -> bool:
        self.rests_s.put(timeout)
        return super().wait(timeout)


class Rig:
    """A source thread, what it delivers, and a clock that the test sets."""

    def __init__(
        self,
        sink: Callable[[int], None] | None = None,
        source: Script | None = None,
        needed: threading.Event | None = None,
    ) -> None:
        self.clock = TurnedClock(0.0)
        self.source = source or Script()
        self.items: queue.Queue[int] = queue.Queue()
        self.capture = SourceThread(
            self.source,
            sink or self.items.put,
            name="camera",
            clock=self.clock,
            needed=needed,
        )

    def item(self) -> int:
        return self.items.get(timeout=WAIT_S)

    def problem(self) -> Sentence:
        """Poll until there is a problem."""
        end_s = monotonic() + WAIT_S
        while (problem := self.capture.problem) is None:
            assert monotonic() < end_s, "no problem is told"
        return problem

    def stop(self) -> None:
        self.source.steps.put(0)
        self.capture.stop()


def test_items_arrive_in_order() -> None:
    """What is read is passed on in order, without a problem."""
    rig = Rig()
    rig.capture.start()
    for number in (1, 2, 3):
        rig.source.steps.put(number)
    assert [rig.item() for _ in range(3)] == [1, 2, 3]
    assert rig.capture.problem is None
    assert rig.capture.failures == 0
    rig.stop()
    assert rig.source.opened == rig.source.closed == 1


def test_a_failing_read_is_told_retried_and_forgotten() -> None:
    """A `SourceError` becomes the problem, the source is reopened, and success clears it."""
    rig = Rig()
    rig.capture.start()
    rig.source.steps.put(SourceError("It is unplugged."))
    assert rig.problem() == says("It is unplugged.")
    rig.source.steps.put(7)
    assert rig.item() == 7
    assert rig.capture.problem is None
    assert rig.source.opened == 2
    assert rig.capture.failures == 1
    rig.stop()
    assert rig.source.closed == 2


def test_any_exception_is_survived() -> None:
    """A source that raises any other exception is closed and reopened, too."""
    rig = Rig()
    rig.capture.start()
    rig.source.steps.put(ZeroDivisionError("by zero"))
    assert str(rig.problem()) == "The camera failed: by zero"
    rig.source.steps.put(1)
    assert rig.item() == 1
    rig.stop()


def test_a_failing_sink_is_survived() -> None:
    """When the sink raises, the source is reopened as after its own failure."""
    fail = [True]
    taken: queue.Queue[int] = queue.Queue()

    def sink(item: int) -> None:
        if fail.pop() if fail else False:
            raise RuntimeError("no")
        taken.put(item)

    rig = Rig(sink)
    rig.capture.start()
    rig.source.steps.put(1)
    assert str(rig.problem()) == "The camera failed: no"
    rig.source.steps.put(2)
    assert taken.get(timeout=WAIT_S) == 2
    rig.stop()


def test_the_same_problem_is_told_once() -> None:
    """A source that cannot be opened is retried and counted each time, but logged once."""
    rig = Rig()
    rig.source.open_error = SourceError("Plug it in.")
    with capture_logs() as logs:
        rig.capture.start()
        assert rig.problem() == says("Plug it in.")
        while rig.source.opened < 5:
            assert rig.capture.problem == says("Plug it in.")
        rig.source.open_error = None
        assert rig.source.reading.wait(WAIT_S)
        rig.stop()
    assert [log["event"] for log in logs] == ["device has a problem"]
    assert rig.capture.failures == rig.source.opened - 1 >= 4


def test_a_hanging_read_becomes_a_problem() -> None:
    """A source that blocks for 3 s is a problem until it returns."""
    rig = Rig()
    rig.capture.start()
    assert rig.source.reading.wait(WAIT_S)
    rig.clock.time_s = 2.9
    assert rig.capture.problem is None
    rig.clock.time_s = 3.1
    with capture_logs() as logs:
        for _ in range(3):
            assert rig.capture.problem == Sentence("camera.silent")
    assert len(logs) == 1
    rig.source.steps.put(5)
    assert rig.item() == 5
    assert rig.capture.problem is None
    assert rig.capture.failures == 0
    rig.stop()


def test_a_source_that_nobody_needs_rests() -> None:
    """It is left unread for as long as it allows, and then once more read to see that it works."""
    need = Need()
    rig = Rig(source=RestingScript(0.001), needed=need)
    rig.capture.start()
    for number in (1, 2):
        rig.source.steps.put(number)
        assert rig.item() == number
        assert need.rests_s.get(timeout=WAIT_S) == 0.001
    rig.source.steps.put(SourceError("It is unplugged."))
    assert rig.problem() == says("It is unplugged.")
    rig.stop()


def test_who_needs_a_source_ends_its_rest() -> None:
    """The next item is read at once, and so is every other while somebody needs them."""
    need = Need()
    rig = Rig(source=RestingScript(3600.0), needed=need)
    rig.capture.start()
    for number in (1, 2, 3):
        rig.source.steps.put(number)
    assert rig.item() == 1
    assert need.rests_s.get(timeout=WAIT_S) == 3600.0
    assert rig.items.empty()
    need.set()
    assert [rig.item(), rig.item()] == [2, 3]
    rig.stop()


def test_what_was_captured_in_a_rest_is_dropped() -> None:
    """A source that queues catches up after each rest, and at no other time."""
    need, caught_up = Need(), threading.Event()
    source = RestingScript(3600.0)
    source.catch_up = caught_up.set  # type: ignore[attr-defined]
    rig = Rig(source=source, needed=need)
    rig.capture.start()
    source.steps.put(1)
    assert need.rests_s.get(timeout=WAIT_S) == 3600.0
    assert not caught_up.is_set()
    need.set()
    assert caught_up.wait(WAIT_S)
    caught_up.clear()
    source.steps.put(2)
    source.steps.put(3)
    assert [rig.item() for _ in range(3)] == [1, 2, 3]
    rig.stop()
    assert not caught_up.is_set()


def test_stop_ends_a_rest() -> None:
    """A source that rests is released as soon as it is to stop."""
    need = Need()
    rig = Rig(source=RestingScript(3600.0), needed=need)
    rig.capture.start()
    rig.source.steps.put(1)
    assert need.rests_s.get(timeout=WAIT_S) == 3600.0
    rig.capture.request_stop()
    assert rig.source.released.wait(WAIT_S)


def test_no_rest_begins_after_a_request_to_stop() -> None:
    """Not even if, after the request, nobody needs the source any longer."""
    need = threading.Event()

    def sink(_item: int) -> None:
        rig.capture.request_stop()
        need.clear()

    rig = Rig(sink, RestingScript(3600.0), need)
    rig.capture.start()
    rig.source.steps.put(1)
    assert rig.source.released.wait(WAIT_S)


def test_a_source_that_may_not_rest_is_read_always() -> None:
    """A source of another package may queue what is not read, and deliver it late."""
    rig = Rig(needed=threading.Event())
    rig.capture.start()
    for number in (1, 2, 3):
        rig.source.steps.put(number)
    assert [rig.item() for _ in range(3)] == [1, 2, 3]
    rig.stop()


def test_stop_is_bounded_and_final() -> None:
    """Stop returns though the source hangs; later items go nowhere; a second stop is harmless."""
    rig = Rig()
    rig.capture.start()
    assert rig.source.reading.wait(WAIT_S)
    done = threading.Thread(target=rig.capture.stop)
    done.start()
    done.join(timeout=3.0)
    assert not done.is_alive()
    rig.capture.stop()
    rig.source.steps.put(9)
    assert rig.items.empty()


def test_stop_ends_the_wait_for_a_retry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stop does not wait for the pause before a retry."""
    monkeypatch.setattr(device_thread, "_RETRY_S", 3600.0)
    rig = Rig()
    rig.source.open_error = SourceError("Plug it in.")
    rig.capture.start()
    assert rig.problem() is not None
    rig.capture.stop()
    assert rig.source.opened == rig.source.closed == 1


def test_stop_without_start() -> None:
    """A thread that was never started can be stopped."""
    rig = Rig()
    rig.capture.stop()
    assert rig.source.opened == 0


def test_all_can_be_asked_to_stop_before_any_is_waited_for() -> None:
    """A stop request returns at once, and the source is released without anybody waiting."""
    rigs = [Rig(), Rig()]
    for rig in rigs:
        rig.capture.start()
        assert rig.source.reading.wait(WAIT_S)
    for rig in rigs:
        rig.capture.request_stop()
        assert rig.source.closed == 0
    for rig in rigs:
        rig.source.steps.put(9)
        assert rig.source.released.wait(WAIT_S)
        rig.capture.stop()
        assert rig.items.empty()
