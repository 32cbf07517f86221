"""The proof: drive, cut a link, measure how long the robot moves on, restore the link, repeat."""

from __future__ import annotations

import asyncio
import contextlib
import random
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax import folders
from wax.commands.proof.line_decoder import language_of
from wax.commands.proof.measure import measure
from wax.commands.proof.observer import Observer
from wax.commands.proof.remote import RemoteOperator
from wax.commands.proof.server import ServerUnderProof, kill
from wax.commands.proof.tap import Tap
from wax.commands.proof.verdict import Finding, Findings, faults_of
from wax.errors import ConfigError, StartError, WaxError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.client.process import Order
    from wax.commands.proof.measure import Sample
    from wax.commands.proof.verdict import Fault
    from wax.commands.proof.watch import Watch
    from wax.config.settings import Settings

_SETTLE_S: Final = 0.5
"""Long enough to reach full speed, and for the gate to recover from the previous fault."""
_PHASE_S: Final = 0.1
"""A fault comes at a random time within this: five ticks, two reports."""
_OBSERVE_S: Final = 1.2
_RECOVER_S: Final = 40.0
_PRESS_S: Final = 2.0
_NEUTRAL_S: Final = 0.4
_LOOK_S: Final = 0.02
_CONNECT_S: Final = 30.0
_REPORT_S: Final = 3.0
_TAPPED: Final = ("frames", "bytes")


@dataclass(frozen=True, slots=True)
class Progress:
    """One line for people; `done` of `of` cuts are finished."""

    line: Sentence
    done: int
    of: int


class Proof:
    """One run over all faults, each `repeats` times ahead, and as often sideways if it can.

    `tell` is called with each step.
    """

    def __init__(
        self, settings: Settings, *, repeats: int, tell: Callable[[Progress], None]
    ) -> None:
        self._settings = settings
        self._ways: tuple[Order, ...] = ("drive",)
        if settings.robot.lateral_mps > 0:
            self._ways = ("drive", "sideways")
        self._repeats = repeats * len(self._ways)
        self._tell = tell
        self._watch = watch_of(settings)
        self._faults = faults_of(self._watch.sees)
        self._done = 0
        self._found: list[Finding] = []

    async def run(self) -> Findings:
        """Cut each link; whatever happens, the robot stands afterwards and nothing is left running.

        If cancelled, or if something fails half-way, it returns the findings so far. Raises
        `WaxError` if it cannot begin.
        """
        self._watch.open()
        broken: str | None = None
        try:
            with folders.temporary("wax-proof-") as folder:
                async with contextlib.AsyncExitStack() as leaving:
                    self._server = ServerUnderProof(
                        Path(folder), self._watch.configuration(self._settings, folder)
                    )
                    leaving.push_async_callback(self._watch.ended)
                    leaving.push_async_callback(self._server.kill)
                    self._operator = RemoteOperator(Path(folder) / "operator.log")
                    leaving.push_async_callback(self._operator.kill)
                    leaving.callback(self._watch.close)  # closed first: the robot stands
                    self._say(Sentence("proof.server_starts"))
                    await self._server.start()
                    await self._operator.start(self._server.url)
                    await self._look_at_the_robot()
                    broken = await self._cut_all()
        finally:
            self._watch.close()
        return self._findings(broken)

    async def _look_at_the_robot(self) -> None:
        """Wait for the robot; raises `StartError` without one, `ConfigError` if it is not seen."""
        end_s = time.monotonic() + _CONNECT_S
        while not (robot := await self._server.robot() or {}).get("connected"):
            if time.monotonic() >= end_s:
                raise StartError(f"the robot is not connected. {robot.get('problem') or ''}")
            await asyncio.sleep(_NEUTRAL_S)
        end_s = time.monotonic() + _REPORT_S
        while (missing := self._watch.missing()) is not None:
            if time.monotonic() >= end_s:
                raise ConfigError(missing)
            await asyncio.sleep(_LOOK_S)

    async def _cut_all(self) -> str | None:
        """Cut each link in turn; return why the proof ended early, if it did."""
        try:
            for fault in self._faults:
                await self._prove(fault)
        except asyncio.CancelledError:
            return "it was aborted."
        except WaxError as error:
            return f"{error}"
        return None

    async def _prove(self, fault: Fault) -> None:
        skipped = self._watch.skips.get(fault.key)
        if skipped is not None:
            self._found.append(Finding(fault, skipped=skipped))
            self._done += self._repeats
            return
        samples: list[Sample] = []
        try:
            for number in range(1, self._repeats + 1):
                self._say(
                    Sentence(
                        "proof.cut", {"fault": fault.title, "number": number, "of": self._repeats}
                    )
                )
                way = self._ways[(number - 1) % len(self._ways)]
                samples.append(await self._sample(fault, way))
                self._done += 1
        finally:
            self._found.append(Finding(fault, tuple(samples)))

    async def _sample(self, fault: Fault, way: Order) -> Sample:
        await self._drive(way)
        driver_pid = await self._server.driver_pid()
        await asyncio.sleep(_SETTLE_S + random.uniform(0.0, _PHASE_S))
        if not self._watch.moves():
            raise StartError(f"the robot has stopped by itself. {self._reason()}")
        fault_s = time.monotonic()
        await self._inject(fault, driver_pid)
        await asyncio.sleep(_OBSERVE_S)
        sample = measure(self._watch.events(), fault_s)
        await self._mend(fault)
        return sample

    async def _inject(self, fault: Fault, driver_pid: int) -> None:
        match fault.key:
            case "silent":
                self._operator.freeze()
            case "stop":
                self._operator.send("stop")
            case "http":
                self._operator.send("stop by http")
            case "leave":
                self._operator.send("leave")
            case "frozen":
                self._server.freeze()
            case "killed":
                await self._server.kill()
            case "driver":
                kill(driver_pid)
            case "cut":
                self._watch.cut()

    async def _mend(self, fault: Fault) -> None:
        self._operator.send("neutral")
        match fault.key:
            case "silent":
                self._operator.thaw()
            case "frozen":
                self._server.thaw()
            case "killed":
                await self._operator.kill()
                await self._server.start()
                await self._operator.start(self._server.url)
            case "cut":
                self._watch.mend()

    async def _drive(self, way: Order) -> None:
        """Get the robot moving, whatever state the last fault left; raises `StartError`."""
        end_s = time.monotonic() + _RECOVER_S
        while time.monotonic() < end_s:
            if await self._may_drive():
                self._operator.send("neutral")
                await asyncio.sleep(_NEUTRAL_S)
                self._watch.forget()
                self._operator.send(way)
                if await self._moves_within(_PRESS_S):
                    return
            await asyncio.sleep(_NEUTRAL_S)
        raise StartError(f"the robot does not start to move. {self._reason()}")

    async def _may_drive(self) -> bool:
        state = self._operator.state
        if not state.is_open:
            await self._operator.kill()
            await self._operator.start(self._server.url)
            return False
        if state.stop is not None:
            self._operator.send("neutral")
            self._operator.send("release")
            return False
        if not state.drives:
            self._operator.send("join")
            return False
        robot = await self._server.robot()
        return robot is not None and bool(robot["connected"])

    async def _moves_within(self, within_s: float) -> bool:
        end_s = time.monotonic() + within_s
        while time.monotonic() < end_s:
            if self._watch.moves():
                return True
            await asyncio.sleep(_LOOK_S)
        return False

    def _reason(self) -> str:
        state = self._operator.state
        if not state.is_open:
            return "Its operator has lost the connection to the server."
        return f"The server says: {state.reason}" if state.reason else "Is its power on?"

    def _say(self, line: Sentence) -> None:
        self._tell(Progress(line, self._done, len(self._faults) * self._repeats))

    def _findings(self, broken: str | None) -> Findings:
        return Findings(
            findings=tuple(self._found),
            repeats=self._repeats,
            reports=self._watch.reports,
            sees=self._watch.sees,
            braking_mps2=self._settings.robot.braking_mps2,
            broken=broken,
        )


def watch_of(settings: Settings) -> Watch:
    """Return what can see this robot: a tap on a line whose language is known, or its driver."""
    robot = settings.robot
    if robot.driver == "serial" and robot.serial.dialect in _TAPPED:
        return Tap(robot.serial, language_of(robot.serial))
    return Observer(robot.driver)
