"""A process that uses too much of the machine."""

from __future__ import annotations

import os
import threading
from typing import TYPE_CHECKING

import pytest
from tests.until import until

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Limits
from wax.robot.process.driver import ProcessDriver
from wax.robot.process.resource_limits import ResourceUse

if TYPE_CHECKING:
    from collections.abc import Callable

MIB = 1 << 20


def test_a_process_like_this_is_none() -> None:
    """An ordinary process, such as the tests, is within the limits."""
    assert ResourceUse().excess(os.getpid()) is None


def test_memory_and_threads_are_counted() -> None:
    """Memory and threads are known for a running process, and unknown for one that has ended."""
    assert str(ResourceUse(max_bytes=MIB).excess(os.getpid())).endswith(" MB")
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        assert str(ResourceUse(max_threads=1).excess(os.getpid())).endswith(" threads")
    finally:
        done.set()
        thread.join()
    assert ResourceUse(max_bytes=0).excess(2**22 + 1) is None


def test_nobody_may_take_more_than_half_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a small machine a driver is ended before the system's OOM killer acts."""
    pages: Callable[[str], int] = {"SC_PHYS_PAGES": 1000, "SC_PAGE_SIZE": 4096}.__getitem__
    monkeypatch.setattr(os, "sysconf", pages)
    assert ResourceUse()._max_bytes == 2_048_000


@pytest.mark.system
def test_a_driver_that_leaks_memory_is_restarted() -> None:
    """A driver that leaks is closed and restarted, with a sentence that says how much it used."""
    settings = RobotSettings(driver="tests.robot.plugins.misbehaving:LeaksMemory")
    limits = Limits(0.6, 1.5, ttl_s=0.2)
    robot = ProcessDriver(settings, SystemClock(), kind="good", limits=limits)
    robot._resource_use = ResourceUse(max_bytes=300 * MIB)
    robot.open()
    try:

        def is_told() -> bool:
            robot.apply(STANDSTILL, 1)
            return "uses more and more of the machine (" in str(robot.state().problem)

        until(is_told)
        until(lambda: robot.state().connected)
        assert robot.state().extra["driver_restarts"] >= 1
    finally:
        robot.close()
