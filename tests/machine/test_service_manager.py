"""The notifications to the service manager."""

from __future__ import annotations

import asyncio
import os
import socket
from contextlib import suppress
from typing import TYPE_CHECKING

import pytest

from wax.machine.service_manager import ServiceManager

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture(params=["path", "abstract"])
def line(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    """Listen as a service manager; yield the address in the environment's form, and the socket."""
    if request.param == "path":
        told = bound = str(tmp_path / "notify")
    else:
        told, bound = f"@wax-{os.getpid()}", f"\0wax-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(bound)
        listening.settimeout(1)
        yield told, listening


def test_it_is_told_of_begin_and_end(line: tuple[str, socket.socket]) -> None:
    """READY and STOPPING arrive at both kinds of address, which no child process inherits."""
    told, listening = line
    environment = {"NOTIFY_SOCKET": told, "HOME": "/"}
    manager = ServiceManager(environment)
    manager.ready()
    manager.stopping()
    assert [listening.recv(99), listening.recv(99)] == [b"READY=1", b"STOPPING=1"]
    assert environment == {"HOME": "/"}


@pytest.mark.parametrize(
    ("variables", "beats"),
    [
        ({"WATCHDOG_USEC": "3000"}, True),
        ({"WATCHDOG_USEC": "3000", "WATCHDOG_PID": str(os.getpid())}, True),
        ({"WATCHDOG_USEC": "3000", "WATCHDOG_PID": "1"}, False),
        ({"WATCHDOG_USEC": "0"}, False),
        ({"WATCHDOG_USEC": "soon"}, False),
        ({}, False),
    ],
)
async def test_only_who_is_watched_gives_signs_of_life(
    tmp_path: Path, variables: dict[str, str], *, beats: bool
) -> None:
    """WATCHDOG is sent three times a period, if the watchdog is for this very process."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.setblocking(False)
        manager = ServiceManager({"NOTIFY_SOCKET": str(tmp_path / "notify"), **variables})
        running = asyncio.create_task(manager.run())
        loop = asyncio.get_running_loop()
        heard: list[bytes] = []
        with suppress(TimeoutError):
            async with asyncio.timeout(5 if beats else 0.02):
                while len(heard) < 3:
                    heard.append(await loop.sock_recv(listening, 99))
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
    assert heard == ([b"WATCHDOG=1"] * 3 if beats else [])


@pytest.mark.parametrize("environment", [{}, {"NOTIFY_SOCKET": ""}, {"NOTIFY_SOCKET": "/no/one"}])
def test_nobody_there_is_no_error(environment: dict[str, str]) -> None:
    """A missing service manager, or one that is gone, raises nothing."""
    ServiceManager(environment).ready()
