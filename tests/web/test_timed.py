"""A request's cost is measured step by step, and its outcome stays the same."""

from __future__ import annotations

import asyncio
import time

import pytest

from wax.web.timed import timed


async def at_once() -> None:
    pass


async def test_each_step_is_charged_and_waiting_is_free() -> None:
    """A wait between two steps costs nothing, and the result is returned."""
    began: list[float] = []

    async def work() -> str:
        await asyncio.sleep(0.01)
        return "done"

    assert await timed(work(), began.append, at_once) == "done"
    assert len(began) == 2
    assert began[0] <= began[1] <= time.thread_time()


async def test_errors_and_cancellation_pass_through() -> None:
    """Both do, inwards and outwards, and the last step is charged, too."""
    charged: list[float] = []

    async def fails() -> None:
        await asyncio.sleep(0)
        raise ValueError("as it was")

    with pytest.raises(ValueError, match="as it was"):
        await timed(fails(), charged.append, at_once)
    seen: list[str] = []

    async def waits() -> None:
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            seen.append("cancelled")
            raise

    task = asyncio.ensure_future(timed(waits(), charged.append, at_once))
    await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert seen == ["cancelled"]
    assert len(charged) == 4


async def test_each_step_waits_for_its_turn() -> None:
    """A cancellation during that wait is raised where the coroutine stands."""
    turns = asyncio.Semaphore(0)
    done: list[int] = []

    async def work() -> None:
        for number in range(3):
            done.append(number)
            await asyncio.sleep(0)

    async def enter() -> None:
        await turns.acquire()

    task = asyncio.ensure_future(timed(work(), lambda _: None, enter))
    for allowed in range(2):
        for _ in range(5):
            await asyncio.sleep(0)
        assert len(done) == allowed
        turns.release()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
