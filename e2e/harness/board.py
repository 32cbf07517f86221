"""The robot's board: the real firmware's core behind a pseudo-terminal, in a process of its own."""

from __future__ import annotations

import asyncio
import json
import os
import time
from asyncio.subprocess import PIPE
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, Self

from e2e.harness.wait import until
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

WHEELS: Final = ("left", "right", "back", "back_left", "back_right")
"""Those that a board may have, by their names in its log."""


class Board:
    """`path` is the serial port while it is plugged in; `log_path` logs what the board does.

    Each line of the log is an event with ``t_s``, which is `time.monotonic()` of this machine:
    ``frame`` (undamaged and of this session; ``verdict`` says whether it was accepted),
    ``damaged``, ``wheels`` (mm/s, when they begin to change and when they have), ``ttl`` (the
    board's own watchdog stopped it), ``start``, ``plugged`` and ``unplugged``. A `base` that moves
    sideways is ``mecanum`` or ``omni``, and logs its back wheels, too.
    """

    def __init__(self, folder: Path, *, boot_ms: int = 0, base: str = "differential") -> None:
        self.path = folder / "robot-port"
        self.log_path = folder / "board.jsonl"
        self._boot_ms = boot_ms
        self._base = base
        self._process: Process | None = None
        self._offset = 0
        self._events: list[dict[str, Any]] = []

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.stop()

    @property
    def robot(self) -> dict[str, Any]:
        """The configuration's `[robot]` for it."""
        robot = {"driver": "serial", "serial": {"url": str(self.path)}}
        return robot if self._base == "differential" else robot | {"base": self._base}

    async def start(self) -> None:
        """Build the firmware if it has changed, and plug the board in."""
        self._process = await asyncio.create_subprocess_exec(*await self._program(), stdin=PIPE)
        with suppress(AttributeError, OSError):  # a real board has a processor of its own
            os.sched_setscheduler(self._process.pid, os.SCHED_RR, os.sched_param(1))
        await self._until("plugged", 0)

    async def stop(self) -> None:
        """End it; safe to call twice."""
        process, self._process = self._process, None
        if process is None or process.returncode is not None:
            return
        assert process.stdin is not None
        process.stdin.close()
        await asyncio.wait_for(process.wait(), 5)

    async def unplug(self) -> float:
        """Pull the cable, while the board keeps running; return when it was out."""
        return await self._do("unplug", "unplugged")

    async def plug(self) -> float:
        """Put the cable back; return when it was in."""
        return await self._do("plug", "plugged")

    async def reset(self) -> float:
        """Restart the board; return when that was."""
        return await self._do("reset", "start")

    def press(self, bumpers: int) -> None:
        """Hold down the bumpers of these bits; 0 releases all."""
        self._command(f"bumper {bumpers}")

    def charge(self, battery_mv: int) -> None:
        self._command(f"battery {battery_mv}")

    def mute(self, *, on: bool) -> None:
        """Send nothing to the server, as with a loose wire."""
        self._command(f"mute {'on' if on else 'off'}")

    def deafen(self, *, on: bool) -> None:
        """Receive nothing from the server, as with a loose wire."""
        self._command(f"deaf {'on' if on else 'off'}")

    def events(self, since_s: float = 0.0) -> list[dict[str, Any]]:
        """Return the events after that moment of `time.monotonic`, oldest first."""
        with self.log_path.open("rb") as log:
            log.seek(self._offset)
            whole, _, _ = log.read().rpartition(b"\n")
        if whole:
            self._offset += len(whole) + 1
            self._events += [json.loads(line) for line in whole.split(b"\n")]
        return [event for event in self._events if event["t_s"] > since_s]

    def greetings(self) -> int:
        """Count the frames that begin a session: more come if an answer is half a second late."""
        frames = [event for event in self.events() if event["event"] == "frame"]
        return sum(frame["type"] == "hello" for frame in frames)

    @property
    def moves(self) -> bool:
        """Whether a wheel turns, by the newest wheel event."""
        wheels = [event for event in self.events() if event["event"] == "wheels"]
        return bool(wheels) and any(wheels[-1].get(wheel) for wheel in WHEELS)

    async def _program(self) -> list[str]:
        files = ["--link", str(self.path), "--log", str(self.log_path)]
        return [await _build(), *files, "--boot-ms", str(self._boot_ms), "--base", self._base]

    def _command(self, command: str) -> None:
        assert self._process is not None, "the board was not started"
        assert self._process.stdin is not None
        self._process.stdin.write(f"{command}\n".encode())

    async def _do(self, command: str, event: str) -> float:
        since_s = time.monotonic()
        self._command(command)
        return await self._until(event, since_s)

    async def _until(self, event: str, since_s: float) -> float:
        """Wait for an event after that moment and return its time."""

        def came() -> float:
            if not self.log_path.exists():
                return 0.0
            found = [one["t_s"] for one in self.events(since_s) if one["event"] == event]
            return float(found[0]) if found else 0.0

        return await until(came, f"the board's log says {event}", every_s=0.002)


async def _build() -> str:
    build = await asyncio.create_subprocess_exec(
        *("sh", ".make/firmware.sh", "board"), cwd=ROOT, stdout=PIPE, stderr=PIPE
    )
    told, complaint = await build.communicate()
    assert build.returncode == 0, complaint.decode()
    return told.decode().splitlines()[-1]
