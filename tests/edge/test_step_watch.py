"""Long steps of the event loop are counted and logged by what they belong to."""

from __future__ import annotations

import asyncio
from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import pytest
from structlog.testing import capture_logs
from tests.turned_clock import TurnedClock

from wax.edge.bounded_selector import bounded_loop
from wax.edge.step_watch import LONG_S, StackSampler, StepWatch, part_of

if TYPE_CHECKING:
    from collections.abc import Iterator

LONGER_S: Final = 2 * LONG_S


@pytest.fixture
def clock() -> TurnedClock:
    return TurnedClock()


@pytest.fixture
def watch(clock: TurnedClock) -> StepWatch:
    return StepWatch(clock.now_s)


@pytest.fixture
def loop(watch: StepWatch) -> Iterator[asyncio.AbstractEventLoop]:
    made = bounded_loop(lambda address: address, watch)
    yield made
    made.close()


class Work:
    """Work that takes its time by a clock turned by hand."""

    def __init__(self, clock: TurnedClock) -> None:
        self._clock = clock

    async def task(self, *steps_s: float) -> None:
        for lasts_s in steps_s:
            self.lasts(lasts_s)
            await asyncio.sleep(0)

    def lasts(self, seconds: float) -> None:
        self._clock.time_s += seconds


def test_a_long_step_is_counted_for_what_it_belongs_to(
    clock: TurnedClock, watch: StepWatch, loop: asyncio.AbstractEventLoop
) -> None:
    """A task's step or a callback counts, even the last of a pass; short ones do not."""
    work = Work(clock)
    watch.start_counting()
    loop.call_soon(work.lasts, LONGER_S)
    loop.run_until_complete(work.task(0.0, LONGER_S, 0.0, 3 * LONG_S))
    assert watch.status() == {
        "edge.test_step_watch.Work.lasts": {"count": 1, "longest_ms": 4.0},
        "edge.test_step_watch.Work.task": {"count": 2, "longest_ms": 6.0},
    }


def test_a_step_that_cancels_its_handle_keeps_its_name(
    clock: TurnedClock, watch: StepWatch, loop: asyncio.AbstractEventLoop
) -> None:
    """A read that stops reading, and a timer that resets itself, cancel their own handles."""
    watch.start_counting()

    def work() -> None:
        own.cancel()
        clock.time_s += LONGER_S
        loop.call_soon(loop.stop)

    own = loop.call_soon(work)
    loop.run_forever()
    (part,) = watch.status()
    assert part.endswith("work")


def test_short_steps_and_waits_are_not_counted(
    clock: TurnedClock, watch: StepWatch, loop: asyncio.AbstractEventLoop
) -> None:
    """However long they take together, whatever is due runs between two of them."""
    watch.start_counting()
    select = vars(loop)["_selector"].select

    def waits(timeout: float | None) -> object:
        found = select(timeout)
        clock.time_s += 1.0
        return found

    vars(loop)["_selector"].select = waits
    loop.run_until_complete(Work(clock).task(*[LONG_S / 2] * 10))
    assert watch.status() == {}


def test_steps_of_the_start_are_not_counted(
    clock: TurnedClock, watch: StepWatch, loop: asyncio.AbstractEventLoop
) -> None:
    """Loading that ends before anybody drives delays nobody."""
    loop.run_until_complete(Work(clock).task(LONGER_S))
    assert watch.status() == {}


def test_a_long_step_is_logged_with_its_stack(
    clock: TurnedClock, watch: StepWatch, loop: asyncio.AbstractEventLoop
) -> None:
    """While a sampler is open, the log gets the part, the time and the calls, but no values."""
    watch.start_counting()

    async def works() -> None:
        clock.time_s += LONG_S
        sampler.sample_stack()  # its own thread would find the step only by the real clock
        clock.time_s += LONG_S

    with StackSampler(watch) as sampler, capture_logs() as logged:
        loop.run_until_complete(works())
    (line,) = logged
    assert line["log_level"] == "warning"
    assert line["part"].endswith("works")
    assert line["ms"] == 4.0
    assert "works" in line["stack"].splitlines()[0]


class _Growing(Counter[str]):
    """Gets another stack from the sampler's thread while its items are iterated over."""

    def items(self) -> Any:
        for item in super().items():
            self["another stack"] = 1
            yield item


def test_a_stack_sampled_while_a_step_is_logged_raises_nothing(
    clock: TurnedClock,
    watch: StepWatch,
    loop: asyncio.AbstractEventLoop,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The sampler's thread runs on; an error here would end the event loop, and the server."""
    monkeypatch.setattr("wax.edge.step_watch.Counter", _Growing)
    watch.start_counting()

    async def works() -> None:
        clock.time_s += LONG_S
        sampler.sample_stack()
        clock.time_s += LONG_S

    with StackSampler(watch) as sampler, capture_logs() as logged:
        loop.run_until_complete(works())
    assert len(logged) == 1


async def _task() -> None: ...


async def test_a_part_says_whose_step_it_is() -> None:
    """It names a task's coroutine, a socket's protocol, or a callback."""
    loop = asyncio.get_running_loop()
    task = loop.create_task(_task())
    own = loop._ready[-1]  # type: ignore[attr-defined]
    transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, ("127.0.0.1", 0))
    read = transport._read_ready  # type: ignore[attr-defined]
    found = [part_of(one) for one in (own._callback, read, partial(partial(task.cancel)))]
    transport.close()
    assert found == [
        "edge.test_step_watch._task",
        "asyncio.protocols.DatagramProtocol",
        "edge.test_step_watch._task",
    ]
