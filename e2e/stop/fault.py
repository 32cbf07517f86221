"""A fault, and one loop for all faults: drive, break, look, mend, and keep holding the control.

Nothing that arrives late or comes back may move the robot before somebody presses again.
"""

from __future__ import annotations

import asyncio
import math
import time
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import counted, summed, timed
from e2e.stop.operator import Browser, RawOperator
from e2e.stop.robots import BOARD, Kind
from e2e.stop.stage import DEFAULT, LIGHT, random_phase, staged, together
from wax.config.settings import Settings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
    from contextlib import AbstractAsyncContextManager

    from e2e.measure.row import Row
    from e2e.stop.record import Stopping
    from e2e.stop.stage import Load, Stage

GOAL_MM: Final = Settings().drive.max_stop_distance_m * 1000


class Scene:
    """A stage and its operator: a client of the protocol, unless a prop sets `press`."""

    def __init__(self, kind: Kind, stage: Stage, rig: Any, *, sees: bool) -> None:
        self.kind, self.stage, self.rig = kind, stage, rig
        self.prop: Any = None
        self.on_socket: Callable[[Any], None] | None = None
        self.press: Callable[[], Awaitable[None]] | None = None
        self.trials = 0
        self._sees = sees
        self._browser = Browser()
        self._leaving = AsyncExitStack()

    async def come(self, *, anew: bool = False) -> None:
        """Connect, or reconnect, and take the turn; `anew` as somebody else."""
        await self.leave()
        self._browser = Browser() if anew else self._browser
        operator = RawOperator(
            self.stage.server, browser=self._browser, on_socket=self.on_socket, sees=self._sees
        )
        self.operator = await self._leaving.enter_async_context(operator)
        await operator.join()

    async def leave(self) -> None:
        await self._leaving.aclose()

    async def drive(self) -> bool:
        """Release, press again, and return at random phase; False if the robot stopped again."""
        self.trials += 1
        if self.press is not None:
            await self.stage.moving(self.press)
            await random_phase()
            return True
        self.operator.is_silent = False
        await self.stage.drive(self.operator, self.kind.way)
        if not self._sees:
            return True
        is_fast = await self.stage.at_full_speed()
        await random_phase()
        return is_fast


def at_once(act: Callable[[Scene], object]) -> Callable[[Scene], Awaitable[float]]:
    """Break by an act that takes no time; the fault begins with it."""

    async def breaks(scene: Scene) -> float:
        since_s = time.monotonic()
        act(scene)
        return since_s

    return breaks


@dataclass(frozen=True, slots=True)
class Fault:
    """`breaks` returns when it broke; `mends` returns when it mended, if that is known only later.

    The row is the time to the first stopping frame, counted from `after_ms`. If `by_itself`, the
    robot's own timeout may come first; if also `late`, only what exceeds that timeout counts.
    Without a goal only motion after the mending counts. A fault so short that driving `resumes` is
    judged until it is mended.

    A `rig` is made before the server, and has `settings` and `environment` for it; a `prop` is made
    after. With `at_full_speed` the operator sees the picture, and the stopping distance has a row.
    Each of several `kinds` is measured `n` times. If there is only one, `at_once` servers may share
    the `n` trials.
    """

    key: str
    what: str
    breaks: Callable[[Scene], Awaitable[float]]
    mends: Callable[[Scene], Awaitable[float | None]]
    goal_ms: float | None = 200.0
    n: int = 100
    minutes: float = 1.0
    kinds: Sequence[Kind] = (BOARD,)
    at_once: int = 1
    look_s: float = 0.3
    held_on_s: float = 0.2
    after_ms: float = 0.0
    judged: str = "max"
    by_itself: bool = False
    late: bool = False
    resumes: bool = False
    at_full_speed: bool = False
    prop: Callable[[Scene], AbstractAsyncContextManager[None]] | None = None
    rig: Callable[[], Any] | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Broken:
    """What one fault did; `moved_ms` are the frames that moved the robot after the mending."""

    kind: Kind
    stopping: Stopping
    moved_ms: list[float]
    mended_ms: float

    def value_ms(self, fault: Fault) -> float | None:
        own_ms = self.kind.time_out_ms if fault.by_itself else None
        ends_ms = self.stopping.told_ms if own_ms is None else self.stopping.ends_ms
        if ends_ms is None:
            return None
        return ends_ms - fault.after_ms - (own_ms or 0.0) * fault.late


async def measure(
    fault: Fault,
    n: int,
    *,
    kinds: Sequence[Kind] | None = None,
    load: Load | None = None,
    **settings: Any,
) -> list[Row]:
    """Run one fault `n` times, on several robots at once, each with its own stage.

    Raises `NotRunError` where this machine has none of the robots.
    """
    wanted = fault.kinds if kinds is None else kinds
    here = [kind for kind in wanted if not kind.missing]
    if not here:
        raise NotRunError("; ".join(kind.missing for kind in wanted))
    at_once = 1 if len(here) > 1 else min(n, fault.at_once)
    stages = here * at_once
    load = (DEFAULT if len(stages) == 1 else LIGHT) if load is None else load

    async def on_a_stage(kind: Kind) -> list[Broken]:
        async with set_up(fault, kind, load, **settings) as scene:
            return await repeated(fault, scene, math.ceil(n / at_once))

    found = await together(*(on_a_stage(kind) for kind in stages))
    rows = rows_of(fault, [one for some in found for one in some])
    return [row.model_copy(update={"load": load.beside(len(stages))}) for row in rows]


@asynccontextmanager
async def set_up(
    fault: Fault, kind: Kind, load: Load, **settings: Mapping[str, Any]
) -> AsyncIterator[Scene]:
    """Set up the scene of a fault, with an operator who has the turn."""
    async with AsyncExitStack() as leaving:
        rig = leaving.enter_context(fault.rig()) if fault.rig else None
        tables, environment = (rig.settings, rig.environment) if rig else ({}, {})
        stage = await leaving.enter_async_context(
            staged(
                *(tables, fault.settings),
                load=load,
                environment=environment,
                end=kind.robot,
                **settings,
            )
        )
        scene = Scene(kind, stage, rig, sees=fault.at_full_speed)
        leaving.push_async_callback(scene.leave)
        if fault.prop:
            await leaving.enter_async_context(fault.prop(scene))
        if scene.press is None:
            await scene.come()
        yield scene


async def repeated(fault: Fault, scene: Scene, n: int) -> list[Broken]:
    """Break and mend until `n` trials count.

    Raises `MeasureError` if most trials are void: then this machine is too busy to measure.
    """
    found: list[Broken] = []
    while len(found) < n:
        broken = await _trial(fault, scene)
        if broken is not None:
            found.append(broken)
        elif scene.trials > 10 + 2 * n:
            raise MeasureError(
                f"{fault.key}: in {scene.trials - len(found)} trials the robot stood before the"
                " fault came; this machine is too busy"
            )
    return found


async def _trial(fault: Fault, scene: Scene) -> Broken | None:
    """Break and mend once; None if the robot had stopped before it broke."""
    if not await scene.drive():
        return None
    since_s = await fault.breaks(scene)
    own_ms = scene.kind.time_out_ms if fault.by_itself else None
    await asyncio.sleep(fault.look_s + (own_ms or 0.0) / 1000)
    mended_s = time.monotonic()
    since_s = await fault.mends(scene) or since_s
    took_ms = (time.monotonic() - mended_s) * 1000
    await asyncio.sleep(fault.held_on_s)
    until_s = mended_s if fault.resumes else time.monotonic()
    record = scene.stage.record
    record.read()
    if not record.moved_at(since_s):
        return None
    after = record.between(mended_s, until_s)
    moved_ms = [(one.at_s - mended_s) * 1000 for one in after if one.moves]
    return Broken(scene.kind, record.stopping(since_s, until_s), moved_ms, took_ms)


def rows_of(fault: Fault, found: Sequence[Broken]) -> list[Row]:
    """Judge the trials of a fault; a row names the robots if there are several."""
    kinds = list(dict.fromkeys(one.kind for one in found))
    names = f": {', '.join(kind.what for kind in kinds)}" if len(kinds) > 1 else ""
    what = f"{fault.what}{names}"
    moved = sum(len(one.moved_ms) for one in found)
    if fault.goal_ms is None:
        return [counted(fault.key, what, moved, len(found))]
    values_ms = [(one.kind, one.value_ms(fault)) for one in found]
    rows = [
        timed(
            fault.key,
            what,
            [ms for _, ms in values_ms],
            fault.goal_ms,
            judged=fault.judged,
            wrong=sum(len(one.stopping.moved_again_ms) for one in found) + moved,
            wrong_ones=[
                {"robot": one.kind.key, **asdict(one.stopping), "after_mending_ms": one.moved_ms}
                for one in found
                if one.stopping.moved_again_ms or one.moved_ms
            ],
            max_by_robot_ms={
                kind.key: max((ms for of, ms in values_ms if of is kind and ms), default=None)
                for kind in kinds
            },
            mended_max_ms=max(one.mended_ms for one in found),
        )
    ]
    if fault.at_full_speed:
        way_mm = [one.stopping.travelled_mm for one in found]
        what = "… way from there to standstill"
        rows.append(summed(f"{fault.key}: distance", what, "mm", way_mm, GOAL_MM))
    return rows
