"""What every test is held to: it leaves no task, thread or descriptor behind."""

from __future__ import annotations

import asyncio
import atexit
import gc
import inspect
import os
import shutil
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
from tests.examples import load_profiles

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

load_profiles()

# No test reads or writes what the servers of whoever runs it remember.
os.environ.pop("STATE_DIRECTORY", None)
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="wax-tests-")
atexit.register(shutil.rmtree, os.environ["XDG_STATE_HOME"], ignore_errors=True)

_DESCRIPTORS = Path("/proc/self/fd")
_SHARED_THREADS = ("asyncio_", "ThreadPoolExecutor", "pytest_timeout")
"""Pools that live as long as the event loop or the process, by the beginnings of their names."""


def _threads() -> set[str]:
    names = {thread.name for thread in threading.enumerate()}
    return {name for name in names if not name.startswith(_SHARED_THREADS)}


def _descriptors() -> set[str]:
    """Open files, sockets and pipes; empty where the system does not tell."""
    found = set()
    for entry in _DESCRIPTORS.iterdir() if _DESCRIPTORS.is_dir() else ():
        try:
            target = str(entry.readlink())
        except OSError:
            continue  # the one that listed this very folder
        if target.startswith(("socket:", "/dev/")):
            found.add(f"{entry.name} {target}")
    return found


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    """Compare threads and descriptors before and after; what is still ending gets a second.

    What waits for the collector is no leak. It is called only where something seems left: to call
    it after each test takes longer than the tests.
    """
    threads, descriptors = _threads(), _descriptors()
    yield
    deadline_s = time.monotonic() + 1
    while time.monotonic() < deadline_s and (_threads() - threads):
        time.sleep(0.01)
    if not _descriptors() <= descriptors:
        gc.collect()
    assert _threads() <= threads
    assert _descriptors() <= descriptors


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
    """Set aside what is loaded by now, so that after each test only its own is looked through."""
    gc.collect()
    gc.freeze()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Hold async tests to leaving no task as well; set up first, so that it looks last."""
    if inspect.iscoroutinefunction(metafunc.function):
        metafunc.fixturenames.insert(0, "_no_task_is_left")
