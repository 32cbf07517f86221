"""Rules for every test: it leaves no task, thread or descriptor behind."""

from __future__ import annotations

import asyncio
import gc
import inspect
import os
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
import structlog
from tests.examples import load_profiles

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

load_profiles()
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read with NumPy; the cores run tests, not one product
gc.disable()  # the objects that exist once the tests are collected are no garbage

# As the server logs: colouring a traceback takes longer than most tests.
structlog.configure(
    [
        *structlog.get_config()["processors"][:-1],
        structlog.dev.ConsoleRenderer(exception_formatter=structlog.dev.plain_traceback),
    ]
)

_DESCRIPTORS = "/proc/self/fd"
_TELLS = Path(_DESCRIPTORS).is_dir()
_SHARED_THREADS = ("asyncio_", "ThreadPoolExecutor", "pytest_timeout")
"""Pools that live as long as the event loop or the process, by the start of their names."""


def _threads() -> set[str]:
    names = {thread.name for thread in threading.enumerate()}
    return {name for name in names if not name.startswith(_SHARED_THREADS)}


def _descriptors() -> set[str]:
    """Return open files, sockets and pipes; empty where the system does not list them.

    Without `Path`, which takes nearly twice as long, since this runs twice for each test.
    """
    found = set()
    for number in os.listdir(_DESCRIPTORS) if _TELLS else ():  # noqa: PTH208
        try:
            target = os.readlink(f"{_DESCRIPTORS}/{number}")  # noqa: PTH115
        except OSError:
            continue  # the descriptor that listed this very folder
        if target.startswith(("socket:", "/dev/")):
            found.add(f"{number} {target}")
    return found


@pytest.fixture(scope="session", autouse=True)
def _own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep away from the state of servers that the user runs."""
    os.environ.pop("STATE_DIRECTORY", None)
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    """Compare threads and descriptors before and after; those that are ending may finish.

    Garbage that waits for the collector is no leak. It is collected only if something seems to be
    left, because collecting after each test would take longer than the tests.
    """
    threads, descriptors = _threads(), _descriptors()
    yield
    deadline_s = time.monotonic() + 10
    while time.monotonic() < deadline_s and (_threads() - threads):
        time.sleep(0.01)
    left = _descriptors() - descriptors
    if left:
        gc.collect()
        left = _descriptors() - descriptors
    assert _threads() <= threads
    assert not left


@pytest_asyncio.fixture
async def _no_task_is_left() -> AsyncIterator[None]:
    """Fail if the test leaves a task running."""
    before = asyncio.all_tasks()
    yield
    for _ in range(10):  # give cancelled tasks the chance to end
        await asyncio.sleep(0)
    left = asyncio.all_tasks() - before - {asyncio.current_task()}
    assert not [task.get_name() for task in left]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start with the slowest tests, so that the other cores do not wait for them at the end."""
    items.sort(key=_may_take_s, reverse=True)


def _may_take_s(item: pytest.Item) -> float:
    marker = item.get_closest_marker("timeout")
    return 0.0 if marker is None else float(marker.args[0])


def pytest_collection_finish() -> None:
    """Exclude all existing objects from garbage collection, and collect the new ones seldom."""
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Check async tests for leftover tasks, too; set up first, so that it checks last."""
    if inspect.iscoroutinefunction(metafunc.function):
        metafunc.fixturenames.insert(0, "_no_task_is_left")
