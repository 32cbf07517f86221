"""Observes any driver's robot by the log of the driver's process (`ObservedRobot`)."""

from __future__ import annotations

import asyncio
import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from wax import folders
from wax.commands.proof.config_file import observed
from wax.commands.proof.measure import Event
from wax.errors import DriverError

if TYPE_CHECKING:
    from tempfile import TemporaryDirectory

    from wax.config.settings import Settings

_NEW_S: Final = 0.3
"""Poses change at least ten times a second, so a robot without news for this long stands."""
_END_S: Final = 2.0
_LOOK_S: Final = 0.02

_DEAD: Final = (
    "the robot's reports are read in that process, so nobody sees how long the robot goes on."
    " Kill it by hand and watch the wheels."
)
_LINK: Final = (
    "no program can cut this robot's link. Pull its plug or take its network away, and watch the"
    " wheels."
)


class Observer:
    """Reads the log from `open` to `close`; the robot's link is out of its reach."""

    sees: Literal["driver"] = "driver"
    reports = True

    def __init__(self, driver: str) -> None:
        self._driver = driver
        self._folder: TemporaryDirectory[str] | None = None
        self._read_to = 0
        self._running = 0
        self._events: list[Event] = []
        self._is_blind: bool | None = None

    @property
    def skips(self) -> dict[str, str]:
        return {"driver": _DEAD, "cut": _LINK}

    def open(self) -> None:
        self._folder = folders.temporary("wax-observed-")

    def configuration(self, settings: Settings, folder: str) -> str:
        return observed(settings, str(self._log), f"{folder}/state")

    def missing(self) -> str | None:
        """Return what the driver's state lacks, None if it reports motion."""
        self._read()
        if self._is_blind is None:
            return (
                f"robot.driver is {self._driver}, and its process has reported nothing; see its"
                " log by starting WAX as usual"
            )
        if self._is_blind:
            return (
                f"robot.driver is {self._driver}, and its state() has neither moving nor pose, so"
                " nobody can tell when the robot stands; let it report one of them, from encoders"
                " or odometry"
            )
        return None

    def cut(self) -> None:
        raise DriverError(_LINK)

    def mend(self) -> None:
        raise DriverError(_LINK)

    def forget(self) -> None:
        self._read()
        self._events = []

    def events(self) -> list[Event]:
        self._read()
        return list(self._events)

    def moves(self) -> bool:
        after_s = time.monotonic() - _NEW_S
        told = [e for e in self.events() if e.who == "told" and e.at_s >= after_s]
        return any(event.moves for event in told)

    def close(self) -> None:
        """Do nothing: the driver's process stops the robot when its server has ended."""

    async def ended(self) -> None:
        """Wait until the last driver's process has stopped and released the robot."""
        end_s = time.monotonic() + _END_S
        self._read()
        while self._running > 0 and time.monotonic() < end_s:
            await asyncio.sleep(_LOOK_S)
            self._read()
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    @property
    def _log(self) -> Path:
        assert self._folder is not None
        return Path(self._folder.name) / "log"

    def _read(self) -> None:
        """Read new lines of the log, except one that is incomplete."""
        if self._folder is None or not self._log.exists():
            return
        with self._log.open("rb") as log:
            log.seek(self._read_to)
            whole = log.read()
        whole = whole[: whole.rfind(b"\n") + 1]
        self._read_to += len(whole)
        for line in whole.splitlines():
            self._take(*json.loads(line))

    def _take(self, at_s: float, what: str, moves: bool, speed_mps: float) -> None:
        match what:
            case "opened":
                self._running = 1  # a process that was killed has closed nothing
            case "closed":
                self._running = 0
            case "said":
                self._events.append(Event(at_s, "said", moves, speed_mps))
            case "told":
                self._is_blind = False
                self._events.append(Event(at_s, "told", moves))
            case "blind":
                self._is_blind = self._is_blind is not False
