"""What every test is held to: it leaves no task, thread or descriptor behind."""

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
gc.disable()  # until the tests are collected, of which nothing is garbage

# As the server logs: to colour a traceback takes longer than most tests.
structlog.configure(
    [
        *structlog.get_config()["processors"][:-1],
        structlog.dev.ConsoleRenderer(exception_formatter=structlog.dev.plain_traceback),
    ]
)

_DESCRIPTORS = "/proc/self/fd"
_TELLS = Path(_DESCRIPTORS).is_dir()
_SHARED_THREADS = ("asyncio_", "ThreadPoolExecutor", "pytest_timeout")
"""Pools that live as long as the event loop or the process, by the beginnings of their names."""


def _threads() -> set[str]:
    names = {thread.name for thread in threading.enumerate()}
    return {name for name in names if not name.startswith(_SHARED_THREADS)}


def _descriptors() -> set[str]:
    """Open files, sockets and pipes; empty where the system does not tell.

    Without `Path`, which takes nearly twice as long, and it is asked twice for each test.
    """
    found = set()
    for number in os.listdir(_DESCRIPTORS) if _TELLS else ():  # noqa: PTH208
        try:
            target = os.readlink(f"{_DESCRIPTORS}/{number}")  # noqa: PTH115
        except OSError:
            continue  # the one that listed this very folder
        if target.startswith(("socket:", "/dev/")):
            found.add(f"{number} {target}")
    return found


@pytest.fixture(scope="session", autouse=True)
def _own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep away from what the servers of whoever runs the tests remember."""
    os.environ.pop("STATE_DIRECTORY", None)
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    """Compare threads and descriptors before and after; what is still ending may do so.

    What waits for the collector is no leak. It is called only where something seems left: to call
    it after each test takes longer than the tests.
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
    """Fail when the test leaves a task running."""
    before = asyncio.all_tasks()
    yield
    for _ in range(10):  # what was cancelled gets the chance to end
        await asyncio.sleep(0)
    left = asyncio.all_tasks() - before - {asyncio.current_task()}
    assert not [task.get_name() for task in left]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what takes longest, so that the other cores do not wait for it at the end."""
    items.sort(key=_may_take_s, reverse=True)


def _may_take_s(item: pytest.Item) -> float:
    marker = item.get_closest_marker("timeout")
    return 0.0 if marker is None else float(marker.args[0])


def pytest_collection_finish() -> None:
    """Set aside what is loaded by now, and look seldom through what comes."""
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Hold async tests to leaving no task as well; set up first, so that it looks last."""
    if inspect.iscoroutinefunction(metafunc.function):
        metafunc.fixturenames.insert(0, "_no_task_is_left")
