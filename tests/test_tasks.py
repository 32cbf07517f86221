"""Supervision: a task that dies is reported once, by name; a stop is quiet and complete."""

from __future__ import annotations

import asyncio

from wax.tasks import TaskSupervisor


async def _die() -> None:
    raise RuntimeError("bug")


async def _end() -> None:
    await asyncio.sleep(0)


async def _live() -> None:
    await asyncio.Event().wait()


async def test_a_task_that_raises_or_returns_is_a_death() -> None:
    """A task that ends by itself, with or without an error, is reported by name."""
    deaths: list[str] = []
    supervisor = TaskSupervisor(deaths.append)
    supervisor.spawn("raises", _die())
    supervisor.spawn("returns", _end())
    supervisor.spawn("lives", _live())
    for _ in range(5):
        await asyncio.sleep(0)
    assert sorted(deaths) == ["raises", "returns"]
    await supervisor.stop()


async def test_a_stop_is_no_death() -> None:
    """Stopping twice cancels everything and reports nothing."""
    deaths: list[str] = []
    supervisor = TaskSupervisor(deaths.append)
    supervisor.spawn("lives", _live())
    await asyncio.sleep(0)
    await supervisor.stop()
    await supervisor.stop()
    assert deaths == []
