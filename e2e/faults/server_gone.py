"""The server is gone, or does nothing: killed, stopped, its event loop blocked."""

from __future__ import annotations

import asyncio
import os
import signal
import time
import uuid
from typing import TYPE_CHECKING, Any, Final

from e2e.faults.camera import CONTROL, Control
from e2e.faults.operator import RawOperator
from e2e.faults.stage import BLIND, SEEING, Stage, staged
from e2e.faults.trials import Trials, repeat, told

if TYPE_CHECKING:
    from collections.abc import Mapping

    from e2e.faults.finding import Figure
    from e2e.faults.record import Stopping

GOAL_MS: Final = 200.0
_LOOK_S: Final = 0.4
_BLOCKED_S: Final = 5.0
_AFTER_S: Final = 0.3
"""So long nothing may move after a server that did nothing goes on, unless newly told."""
_LANES: Final = 3
"""So many blocked servers at once: they and their robots have nothing to do meanwhile."""


async def server_killed(n: int, **settings: Mapping[str, Any]) -> Figure:
    """From SIGKILL to the server's process; the one that speaks with the robot is not signalled."""
    async with staged(BLIND, settings) as stage:

        async def trial() -> Stopping | None:
            async with RawOperator(stage.server) as operator:
                await operator.join()
                await stage.drive(operator)
                since_s = time.monotonic()
                os.kill(stage.server.pid, signal.SIGKILL)
                await asyncio.sleep(_LOOK_S)
                until_s = time.monotonic()
            await stage.again()
            stage.record.read()
            if not stage.record.moved_at(since_s):
                return None
            return stage.record.stopping(since_s, until_s)

        trials = await repeat("server-killed", n, trial)
    return told("server-killed", "SIGKILL → stop frame", trials, GOAL_MS)


async def server_stopped(n: int, **settings: Mapping[str, Any]) -> Figure:
    """From SIGSTOP to the server's process; when it goes on, nothing late may move the robot."""
    async with staged(BLIND, settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()

        async def trial() -> Stopping | None:
            await stage.drive(operator)
            since_s = time.monotonic()
            os.kill(stage.server.pid, signal.SIGSTOP)
            try:
                await asyncio.sleep(_LOOK_S)
            finally:
                # What is sent now waits in the sockets of the stopped server, together with what
                # came before: none of it may move anything.
                operator.is_silent = True
                await asyncio.sleep(0.02)
                os.kill(stage.server.pid, signal.SIGCONT)
            await asyncio.sleep(_AFTER_S)
            until_s = time.monotonic()
            operator.is_silent = False
            return _stopping(stage, since_s, until_s)

        trials = await repeat("server-stopped", n, trial)
    return told("server-stopped", "SIGSTOP → stop frame", trials, GOAL_MS)


async def loop_blocked(n: int, **settings: Mapping[str, Any]) -> Figure:
    """From the moment at which the event loop is blocked for 5 s, everything else running.

    The suite's own camera does it, a plug-in like anybody's: it asks the loop that runs in its
    process to sleep. That server's other threads and processes go on.
    """
    lanes = min(_LANES, n)
    shares = [n // lanes + (lane < n % lanes) for lane in range(lanes)]
    async with asyncio.TaskGroup() as group:
        found = [group.create_task(_blocked(share, settings)) for share in shares]
    trials: Trials[Stopping] = Trials()
    for lane in found:
        trials.add(lane.result())
    what = "event loop blocked 5 s → stop frame"
    return told("loop-blocked", what, trials, GOAL_MS, servers_at_once=lanes)


async def _blocked(n: int, settings: Mapping[str, Mapping[str, Any]]) -> Any:
    with Control() as control:
        camera = {"video": {"source": "e2e.faults.camera:Camera"}}
        environment = {CONTROL: str(control.folder)}
        client = str(uuid.uuid4())
        async with staged(SEEING, camera, settings, environment=environment) as stage:

            async def trial() -> Stopping | None:
                # A new connection each time: after 5 s without an answer the old one is slow.
                async with RawOperator(stage.server, client=client) as operator:
                    await operator.join()
                    await stage.drive(operator)
                    since_s = await control.block(_BLOCKED_S)
                    await asyncio.sleep(_BLOCKED_S - 0.2)
                    operator.is_silent = True
                    await asyncio.sleep(0.2 + _AFTER_S)
                    return _stopping(stage, since_s, time.monotonic())

            return await repeat("loop-blocked", n, trial)


def _stopping(stage: Stage, since_s: float, until_s: float) -> Stopping | None:
    stage.record.read()
    if not stage.record.moved_at(since_s):
        return None
    return stage.record.stopping(since_s, until_s)
