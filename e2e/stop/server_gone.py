"""The server is gone or hangs: killed, stopped, or with its event loop blocked."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from typing import TYPE_CHECKING, Any, Final

from e2e.stop.camera import PLUG_IN, Control
from e2e.stop.operator import Browser, RawOperator
from e2e.stop.stage import staged
from e2e.stop.trials import repeat, told

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.record import Stopping

GOAL_MS: Final = 200.0
_LOOK_S: Final = 0.4
_BLOCKED_S: Final = 5.0
_AFTER_S: Final = 0.3
"""How long nothing may move after a hanging server resumes, without a new command."""


async def server_killed(n: int, **settings: Any) -> Row:
    """Time from SIGKILL to the server's process; the driver's process is not signalled."""
    async with staged(**settings) as stage:

        async def trial() -> Stopping | None:
            async with RawOperator(stage.server) as operator:
                await operator.join()
                await stage.drive(operator)
                since_s = time.monotonic()
                os.kill(stage.server.pid, signal.SIGKILL)
                await asyncio.sleep(_LOOK_S)
                until_s = time.monotonic()
            await stage.again()
            return stage.outcome(since_s, until_s)

        trials = await repeat("server-killed", n, trial)
    return told("server-killed", "server killed → stop frame", trials, GOAL_MS)


async def server_stopped(n: int, **settings: Any) -> Row:
    """Time from SIGSTOP to the server's process; after it resumes, nothing late may move."""
    async with staged(**settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()

        async def trial() -> Stopping | None:
            await stage.drive(operator)
            since_s = time.monotonic()
            os.kill(stage.server.pid, signal.SIGSTOP)
            try:
                await asyncio.sleep(_LOOK_S)
            finally:
                # Commands sent now wait in the sockets of the stopped server, behind earlier ones:
                # none of them may move anything.
                operator.is_silent = True
                await asyncio.sleep(0.02)
                os.kill(stage.server.pid, signal.SIGCONT)
            await asyncio.sleep(_AFTER_S)
            operator.is_silent = False
            return stage.outcome(since_s)

        trials = await repeat("server-stopped", n, trial)
    return told("server-stopped", "server stopped (SIGSTOP) → stop frame", trials, GOAL_MS)


async def loop_blocked(n: int, **settings: Any) -> Row:
    """Time from blocking the event loop for 5 s, with everything else running.

    The suite's own camera does it, a plug-in like anybody's: it asks the loop that runs in its
    process to sleep. That server's other threads and processes go on.
    """
    browser = Browser()
    with Control() as control:
        async with staged(PLUG_IN, environment=control.environment, **settings) as stage:

            async def trial() -> Stopping | None:
                # A new connection each time: after 5 s without an answer the old one is slow.
                async with RawOperator(stage.server, browser=browser) as operator:
                    await operator.join()
                    await stage.drive(operator)
                    since_s = await control.block(_BLOCKED_S)
                    await asyncio.sleep(_BLOCKED_S - 0.2)
                    operator.is_silent = True
                    await asyncio.sleep(0.2 + _AFTER_S)
                    return stage.outcome(since_s)

            trials = await repeat("loop-blocked", n, trial)
    return told("loop-blocked", "server's event loop blocked for 5 s → stop frame", trials, GOAL_MS)
