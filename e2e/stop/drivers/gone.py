"""The driver's process is killed or frozen, and its link cut and mended while a control is held."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.harness.wait import eventually
from e2e.measure.row import counted
from e2e.stop.drivers.robots import End
from e2e.stop.operator import RawOperator
from e2e.stop.stage import random_phase, staged
from e2e.stop.trials import repeat, told

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.drivers.robots import Kind
    from e2e.stop.record import Stopping

_LOOK_S: Final = 0.3
_HELD_ON_S: Final = 0.5
_BACK_S: Final = 20.0


async def driver_killed(
    kind: Kind, n: int, *, by: signal.Signals = signal.SIGKILL, **settings: Any
) -> Row:
    """Time from SIGKILL to the driver's process to standstill, by message or by the robot.

    With SIGSTOP it is frozen, until the server kills it.
    """
    assert kind.stops_ms is not None
    look_s = kind.stops_ms / 1000 + _LOOK_S
    async with staged(end=kind.robot, **settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()

        async def trial() -> Stopping | None:
            await stage.answers(_BACK_S)
            await stage.drive(operator)
            pid = stage.driver_pid
            await random_phase()
            since_s = time.monotonic()
            os.kill(pid, by)
            await asyncio.sleep(look_s)
            # The new process starts from neutral, although the control is still held down.
            outcome = stage.outcome(since_s)
            await eventually(partial(_has_ended, pid), "the server kills it", every_s=0.02)
            return outcome

        trials = await repeat("driver-killed", n, trial)
    how = "the robot stops by itself" if kind.by_itself else "standstill, by the standby"
    what = f"driver’s process {'killed' if by is signal.SIGKILL else 'frozen'} → {how}"
    return told("driver-killed", what, trials, kind.stops_ms, by_board=kind.by_itself)


async def _has_ended(pid: int) -> bool:
    return not psutil.pid_exists(pid)


async def link_cut(kind: Kind, n: int, **settings: Any) -> Row:
    """Count how often the robot moves when its link is back, while the control is held on."""
    async with staged(end=kind.robot, **settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()
        robot = stage.robot
        assert isinstance(robot, End)

        async def is_lost() -> bool:
            return not (await stage.server.status())["robot"]["connected"]

        async def trial() -> bool | None:
            await stage.drive(operator)
            await robot.cut()
            await eventually(is_lost, "the server knows of the loss", within_s=10, every_s=0.02)
            mended_s = time.monotonic()
            await robot.mend()
            await stage.answers(_BACK_S)
            await asyncio.sleep(_HELD_ON_S)
            stage.record.read()
            return any(one.moves for one in stage.record.between(mended_s, time.monotonic()))

        trials = await repeat("link-cut", n, trial)
    what = "link cut and mended: motions without a new deliberate command"
    return counted("link-cut", what, sum(trials.results), len(trials.results))
