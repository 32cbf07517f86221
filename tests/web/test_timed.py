"""What a request costs is measured step by step, and how it ends stays as it was."""

from __future__ import annotations

import asyncio
import time

import pytest

from wax.web.timed import timed


async def test_each_step_is_charged_and_waiting_is_free() -> None:
    """Two steps with a wait between them; the result comes through."""
    began: list[float] = []

    async def work() -> str:
        await asyncio.sleep(0.01)
        return "done"

    assert await timed(work(), began.append) == "done"
    assert len(began) == 2
    assert began[0] <= began[1] <= time.thread_time()


async def test_errors_and_cancellation_pass_through() -> None:
    """Inwards and outwards, and each last step is charged, too."""
    charged: list[float] = []

    async def fails() -> None:
        await asyncio.sleep(0)
        raise ValueError("as it was")

    with pytest.raises(ValueError, match="as it was"):
        await timed(fails(), charged.append)
    seen: list[str] = []

    async def waits() -> None:
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            seen.append("cancelled")
            raise

    task = asyncio.ensure_future(timed(waits(), charged.append))
    await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert seen == ["cancelled"]
    assert len(charged) == 4
