"""A robot, and a server that drives it, in a folder of their own."""

from __future__ import annotations

import asyncio
import os
import random
import signal
import time
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, TypeVar
from weakref import WeakKeyDictionary

import psutil
import tomlkit

from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.server import Server
from e2e.harness.wait import happens
from e2e.load.crowd.crowd import gathered
from e2e.load.crowd.sample import Offering
from e2e.measure.errors import MeasureError
from e2e.stop.record import Record

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Mapping, Sequence

    from e2e.load.crowd.crowd import Crowd
    from e2e.stop.operator import RawOperator

    Act = Callable[[], Awaitable[object]]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Load:
    """What the server serves while the robot drives: its media, and a number of observers."""

    what: str
    media: Mapping[str, Any]
    observers: int

    def __str__(self) -> str:
        return f"{self.what}, {self.observers} observers"

    def beside(self, servers: int) -> str:
        """Return the load in words, with the number of servers that run at once."""
        return f"{self}, {servers} such servers at once" if servers > 1 else str(self)


DEFAULT: Final = Load("640×480 at 30 fps, sound", toml.MEDIA, 20)
"""The product as shipped."""

_SMALL: Final = {"width": 320, "height": 240, "fps": 15.0}
LIGHT: Final = Load(
    "320×240 at 15 fps, no sound",
    {
        "video": {"source": "testcard", "renditions": [_SMALL | {"bitrate_bps": 300_000}]} | _SMALL,
        "audio": {"source": "none"},
    },
    0,
)
"""For tests, which share the machine."""

_STARTING: Final = WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Semaphore]()
_PRESSES: Final = 6
_PRESS_S: Final = 1.5

_STEADY_FRAMES: Final = 5
"""The speed is steady after this many equal ones in a row: two may fall in one period of a rise."""
_RAMP_S: Final = 1.5

_LONG_TURNS: Final = {"turns": {"turn_s": 3600.0, "grace_s": 0.5}}

STOPS_AT_EACH_TRIAL: Final = {
    "stop": {"max_per_minute": 10_000, "max_per_minute_per_address": 10_000, "release_after_s": 0}
}
"""Lets observers press Stop in each trial, far more often than people may."""


async def _nothing() -> None:
    pass


@dataclass(frozen=True, slots=True)
class Robot:
    """The robot at the other end of a driver's link: its record, and `[robot]` for it.

    `start` makes it ready to be driven, `stop` ends it and is safe to call twice; `cut` cuts its
    link, and `mend` restores it.
    """

    record: Record
    settings: Mapping[str, Any]
    start: Act = _nothing
    stop: Act = _nothing
    cut: Act = _nothing
    mend: Act = _nothing
    environment: Mapping[str, str] = field(default_factory=dict)


def behind_a_cable(board: Board, record: Record) -> Robot:
    return Robot(record, board.robot, board.start, board.stop, board.unplug, board.plug)


def firmware(folder: Path, base: str = "differential") -> Robot:
    board = Board(folder, base=base)
    return behind_a_cable(board, Record(board.log_path))


class Stage:
    """A robot, and the server that is connected to it."""

    def __init__(self, robot: Robot, server: Server, load: Load) -> None:
        self.robot = robot
        self.server = server
        self.load = load
        self.record = robot.record
        self.crowd: Crowd | None = None

    async def start(self) -> None:
        """Start the server, a few at a time, since starting takes a core."""
        async with _STARTING.setdefault(asyncio.get_running_loop(), asyncio.Semaphore(2)):
            await self.server.start()
            await self.answers()

    async def hold(self, observers: int) -> None:
        """Have this many observers; none if the server is gone."""
        if self.crowd is not None:
            await self.crowd.hold(observers)

    async def is_loaded(self) -> None:
        """Raise `MeasureError` if observers were lost: the load was not as stated."""
        here = len((await self.server.status())["viewers"])
        if here < self.load.observers:
            raise MeasureError(f"of {self.load.observers} observers {here} were left at the end")

    async def answers(self) -> None:
        await self.server.until(
            lambda told: told["robot"]["connected"], "the robot is found", within_s=20, every_s=0.05
        )

    async def again(self) -> None:
        """Restart the killed server on the same port."""
        await self.server.kill()
        await asyncio.gather(self.hold(0), self.start())
        await self.hold(self.load.observers)

    @property
    def driver_pid(self) -> int:
        for child in psutil.Process(self.server.pid).children(recursive=True):
            if "wax.robot.process" in child.cmdline():
                return int(child.pid)
        raise MeasureError("the server has no process that speaks with the robot")

    # --- what the robot does -------------------------------------------------------------------

    async def moves(self, within_s: float) -> bool:
        """Return whether the wheels turn within that time because of a current command."""

        async def is_moving() -> bool:
            self.record.read()
            return self.record.moved_at(time.monotonic())

        return await happens(is_moving, within_s=within_s, every_s=0.005)

    async def moving(self, press: Callable[[], Awaitable[None]]) -> None:
        """Press, and again if the server requires it, until the robot moves."""
        for _ in range(_PRESSES):
            await press()
            if await self.moves(_PRESS_S):
                return
        state = await self.server.status()
        refused = {name: n for name, n in state["counters"].items() if "refused" in name}
        raise MeasureError(
            f"the robot does not move, pressed {_PRESSES} times:"
            f" {state['turn']}, {refused}, {state['robot']}"
        )

    async def at_full_speed(self) -> bool:
        """Wait until the commanded speed stays level; False if the robot stands before that."""
        deadline_s = time.monotonic() + _RAMP_S
        while time.monotonic() < deadline_s:
            self.record.read()
            newest = self.record.frames[-_STEADY_FRAMES:]
            if not newest[-1].moves:
                return False
            if len({frame.speeds for frame in newest}) == 1:
                return True
            await asyncio.sleep(0.005)
        return False

    async def drive(self, operator: RawOperator, way: Sequence[float] = (1.0,)) -> None:
        """Release, press again, and return at random phase while the robot moves.

        `way` is what the operator holds: ahead, turning and sideways, as shares of the limits.
        """

        async def press() -> None:
            operator.let_go()
            await asyncio.sleep(0.06)
            operator.steer(*way)

        await self.moving(press)
        await random_phase()


async def random_phase() -> None:
    """Wait for a random time, longer than any period of the system."""
    await asyncio.sleep(random.uniform(0.06, 0.16))


async def together(*works: Coroutine[Any, Any, T]) -> list[T]:
    """Run all at once; if one fails, end the others and raise its error."""
    try:
        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(work) for work in works]
    except BaseExceptionGroup as errors:
        raise errors.exceptions[0] from None
    return [task.result() for task in tasks]


@asynccontextmanager
async def staged(
    *tables: Mapping[str, Any],
    load: Load = DEFAULT,
    environment: Mapping[str, str] | None = None,
    end: Callable[[Path], Robot] = firmware,
    **settings: Mapping[str, Any],
) -> AsyncIterator[Stage]:
    """Set up a stage in a temporary folder; `settings` override `tables`.

    `end` makes the robot at the other end of the driver's link.
    """
    drivers: list[int] = []
    with TemporaryDirectory(prefix="wax-stop-") as folder:
        robot = end(Path(folder))
        tree = toml.merged(_LONG_TURNS, load.media, {"robot": robot.settings}, *tables, settings)
        server = Server(Path(folder), tomlkit.dumps(tree))
        server.environment |= dict(robot.environment) | dict(environment or {})
        stage = Stage(robot, server, load)
        async with AsyncExitStack() as leaving:
            # With a person aboard, the driver's process outlives its server.
            leaving.callback(_kill, drivers)
            await robot.start()
            leaving.push_async_callback(robot.stop)
            leaving.push_async_callback(server.kill)
            await stage.start()
            if load.observers:
                observers = gathered(Offering(url=server.url, how="wax"))
                stage.crowd = await leaving.enter_async_context(observers)
                await stage.hold(load.observers)
            try:
                yield stage
                if load.observers:
                    await stage.is_loaded()
            finally:
                with suppress(MeasureError, psutil.Error):
                    drivers.append(stage.driver_pid)


def _kill(pids: list[int]) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
