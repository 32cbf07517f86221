"""The person aboard touches their hand control while an operator drives at full speed.

The control is a pseudo-terminal that speaks as a real one does: 50 times a second, and at once when
it is touched. Its person drives back, so that each set-point says whose it is.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import random
import signal
import time
import tty
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, Self

from e2e.measure.row import counted, timed
from e2e.stop.logged_robot import CALLS, PLUG_IN, Calls
from e2e.stop.operator import RawOperator
from e2e.stop.stage import staged
from e2e.stop.trials import repeat
from wax.driver.hand import HandReading
from wax.robot.hand.line import encode

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.measure.row import Row
    from e2e.stop.stage import Stage
    from e2e.stop.trials import Trials

P99_MS: Final = 20.0
MAX_MS: Final = 45.0
WIRE_MS: Final = 70.0

_PERIOD_S: Final = 0.02
_PAUSE_S: Final = 0.5
_LOOK_S: Final = 0.3
_FROZEN_S: Final = 0.06
"""The touch comes within this time of the server's end, before its silence stops the robot."""
_BACK: Final = -0.5
_REST: Final = HandReading(0.0)


class HandControl:
    """Use as an async context manager; `url` is its port."""

    def __init__(self) -> None:
        self._end, self._port = os.openpty()
        tty.setraw(self._port)
        os.set_blocking(self._end, False)
        self.url = os.ttyname(self._port)
        self._does = _REST
        self._number = 0
        self._speaking: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        self._speaking = asyncio.create_task(self._speak())
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._speaking is not None:
            self._speaking.cancel()
        for descriptor in (self._end, self._port):
            os.close(descriptor)

    def touch(self) -> float:
        """Push the stick back; return when."""
        now_s = time.monotonic()
        self._does = HandReading(0.0, linear=_BACK)
        self._say()
        return now_s

    def let_go(self) -> None:
        self._does = _REST
        self._say()

    async def _speak(self) -> None:
        while True:
            self._say()
            await asyncio.sleep(_PERIOD_S)

    def _say(self) -> None:
        self._number += 1
        with contextlib.suppress(BlockingIOError):  # nobody reads it yet
            os.write(self._end, encode(self._does, self._number))


@dataclass(frozen=True, slots=True)
class Taken:
    """One touch, in ms from it: the last that is the operator's has been applied, on the wire.

    On the wire it ends with a stop, or with what the person asks for themselves: where the two come
    between two frames, there is no frame for the stop.
    """

    applied_ms: float | None
    wire_ms: float | None
    drives: bool
    wrong: int


async def hand_touched(n: int, **settings: Any) -> list[Row]:
    """Time from the touch to the stop, at the driver and on the wire, with the server running."""
    return _rows("hand", "hand touched", await _touched(n, is_frozen=False, **settings))


async def hand_touched_server_stopped(n: int, **settings: Any) -> list[Row]:
    """Do the same with the server stopped (SIGSTOP) just before the touch."""
    what = "hand touched, server stopped (SIGSTOP)"
    return _rows("hand-alone", what, await _touched(n, is_frozen=True, **settings))


@asynccontextmanager
async def _seated(**settings: Any) -> AsyncIterator[tuple[Stage, HandControl, Calls]]:
    """Set up a stage with a person aboard."""
    with TemporaryDirectory(prefix="wax-faults-") as folder:
        path = Path(folder) / "calls"
        path.touch()
        async with HandControl() as control:
            local = {"source": "serial", "url": control.url, "pause_s": _PAUSE_S}
            tables = (PLUG_IN, {"local": local})
            environment = {CALLS: str(path)}
            driver: int | None = None
            try:
                async with staged(*tables, environment=environment, **settings) as stage:
                    try:
                        yield stage, control, Calls(path)
                    finally:
                        driver = stage.driver_pid
            finally:
                if driver is not None:  # the stage kills its server, which this one outlives
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(driver, signal.SIGKILL)


async def _touched(n: int, *, is_frozen: bool, **settings: Any) -> Trials[Taken]:
    async with _seated(**settings) as (stage, control, calls), RawOperator(stage.server) as driver:
        await driver.join()

        async def trial() -> Taken | None:
            await stage.drive(driver)
            if not await stage.at_full_speed():
                return None
            if is_frozen:
                os.kill(stage.server.pid, signal.SIGSTOP)
                await asyncio.sleep(random.uniform(0.0, _FROZEN_S))
            try:
                since_s = control.touch()
                await asyncio.sleep(_LOOK_S)
            finally:
                if is_frozen:
                    os.kill(stage.server.pid, signal.SIGCONT)
            taken = _taken(stage, calls, since_s)
            control.let_go()
            await asyncio.sleep(_PAUSE_S)
            return taken

        return await repeat("hand", n, trial)


def _taken(stage: Stage, calls: Calls, since_s: float) -> Taken | None:
    """Return what came of a touch; None if the robot stood before it."""
    if stage.outcome(since_s) is None:
        return None
    frames = stage.record.between(since_s, time.monotonic())
    wire_s = next((one.at_s for one in frames if max(one.left_mmps, one.right_mmps) <= 0), None)
    told = calls.since(since_s)
    stop_s = next((call.at_s for call in told if call.word == "stop"), None)
    after = [call for call in told if stop_s is not None and call.at_s > stop_s]
    return Taken(
        applied_ms=None if stop_s is None else (stop_s - since_s) * 1000,
        wire_ms=None if wire_s is None else (wire_s - since_s) * 1000,
        drives=any(call.linear_mps < 0.0 for call in after),
        wrong=sum(call.linear_mps > 0.0 for call in after),
    )


def _rows(key: str, what: str, trials: Trials[Taken]) -> list[Row]:
    found = trials.results
    applied_ms = [one.applied_ms for one in found]
    return [
        timed(
            f"{key}: applied",
            f"{what} → the operator's set-point is applied no more",
            applied_ms,
            P99_MS,
            judged="p99",
            void=trials.void,
        ),
        timed(f"{key}: applied, at most", "… at most", applied_ms, MAX_MS),
        timed(f"{key}: wire", "… and on the wire", [one.wire_ms for one in found], WIRE_MS),
        counted(
            f"{key}: operator",
            "… set-points of the operator's applied after it",
            sum(one.wrong for one in found),
            len(found),
        ),
        counted(
            f"{key}: person",
            "… touches that did not drive",
            sum(not one.drives for one in found),
            len(found),
        ),
    ]
