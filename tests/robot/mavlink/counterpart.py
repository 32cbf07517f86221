"""The rover: a program in Rust on another MAVLink library than pymavlink."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import threading
import time
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest

from wax.driver.interface import STANDSTILL, Twist

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT: Final = Path(__file__).resolve().parents[3]
SOURCE: Final = Path(__file__).with_name("rover_program")
TARGET: Final = ROOT / ".cache" / "mavlink-rover"
OLDEST_CARGO: Final = (1, 88)
NAMES: Final = {"guided": 15, "manual": 0, "acro": 1, "hold": 4}
PARAMETERS: Final = {
    "FS_GCS_ENABLE": 1.0,
    "FS_GCS_TIMEOUT": 1.0,
    "FS_TIMEOUT": 0.5,
    "FS_ACTION": 2.0,
    "FS_THR_ENABLE": 1.0,
    "GUID_TIMEOUT": 1.0,
    "SYSID_MYGCS": 255.0,
}
LIMITS: Final = (0.6, 1.5)
"""The limits in the robot's settings: full stick deflection."""


@cache
def build() -> Path:
    """Build the program; skip the test without a recent enough Rust."""
    cargo = shutil.which("cargo")
    told = "" if cargo is None else subprocess.check_output([cargo, "--version"], text=True)
    version = re.search(r"(\d+)\.(\d+)", told)
    if cargo is None or version is None or (int(version[1]), int(version[2])) < OLDEST_CARGO:
        pytest.skip("the rover is built by cargo 1.88 or newer, which is not installed")
    subprocess.run(
        [cargo, "build", "--quiet", "--locked"],
        cwd=SOURCE,
        env=os.environ | {"CARGO_TARGET_DIR": str(TARGET)},
        check=True,
    )
    return TARGET / "debug" / "rover"


def wall_s() -> float:
    """Return the wall-clock time, as the rover logs it."""
    return time.time_ns() / 1e9


class Rover:
    """A rover in a process of its own, and the events that it has reported."""

    def __init__(
        self,
        address: str,
        *,
        system: int = 1,
        key: str = "none",
        mode: str = "hold",
        armed: bool = False,
        **parameters: float | None,
    ) -> None:
        told = {
            name: value for name, value in (PARAMETERS | parameters).items() if value is not None
        }
        self._process = subprocess.Popen(
            [
                build(),
                address,
                str(system),
                key,
                *(f"{name}={value}" for name, value in told.items()),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._lock = threading.Lock()
        self._events: list[dict[str, Any]] = []
        self._taken = 0
        self._thread = threading.Thread(target=self._collect, name="rover", daemon=True)
        self._thread.start()
        self.command(f"mode {NAMES[mode]}", *(("arm",) if armed else ()))

    def command(self, *lines: str) -> None:
        """Change its state, as a person next to it could."""
        assert self._process.stdin is not None
        for line in lines:
            self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def events(self, *kinds: str) -> list[dict[str, Any]]:
        """Return its events so far, or those of `kinds`."""
        with self._lock:
            return [event for event in self._events if not kinds or event["event"] in kinds]

    def new_setpoints(self) -> list[Twist]:
        """Return the set-points that have reached it since the last call."""
        return [twist for event in self.new_events() if (twist := as_twist(event)) is not None]

    def new_events(self) -> list[dict[str, Any]]:
        """Return its events since the last call."""
        with self._lock:
            new, self._taken = self._events[self._taken :], len(self._events)
        return new

    def until(self, so: Callable[[], bool], what: str, within_s: float = 5.0) -> None:
        """Wait until `so` holds."""
        end_s = time.monotonic() + within_s
        while not so():
            assert time.monotonic() < end_s, (
                f"not within {within_s} s it {what}: {self.events()[-9:]}"
            )
            time.sleep(0.002)

    @property
    def drives(self) -> bool:
        """Whether it moves, by its newest event."""
        moves = self.events("moves")
        return bool(moves) and (moves[-1]["mps"], moves[-1]["rps"]) != (0.0, 0.0)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._thread.join()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()

    def _collect(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            event = json.loads(line)
            with self._lock:
                self._events.append(event)


def as_twist(event: dict[str, Any]) -> Twist | None:
    """Return an event's set-point in our directions; None for other events."""
    match event["event"]:
        case "velocity":
            return Twist(event["vx"], -event["yaw_rate"]) if event["frame"] == 8 else STANDSTILL
        case "manual":
            linear_mps, angular_rps = LIMITS
            return Twist(event["z"] / 1000 * linear_mps, -event["y"] / 1000 * angular_rps)
    return None
