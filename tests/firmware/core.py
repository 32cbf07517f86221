"""The firmware's core as a shared library: the real C++, on a clock turned by hand."""

from __future__ import annotations

import ctypes
import enum
import os
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from wax.robot.serial.frames import (
    AxisBody,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    StopBody,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.robot.serial.frames import Body

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "server" / "firmware"
AXES = 4
WHEELS = 4


class Verdict(enum.IntEnum):
    """The core's verdict on a frame; the numbers are those of `robot.h`."""

    TAKEN = 1
    OLD_TURN = 2
    OLD_SEQUENCE = 3
    LATE = 4
    TIMED_OUT = 5
    CANNOT = 6


class Kind(enum.IntEnum):
    """How the wheels stand; the numbers are those of `base.h`."""

    SIDES = 0
    MECANUM = 1
    OMNI = 2

    @property
    def wheels(self) -> int:
        return {Kind.SIDES: 2, Kind.MECANUM: 4, Kind.OMNI: 3}[self]


@dataclass(frozen=True, slots=True)
class Settings:
    acceleration_mmps2: int = 2500
    braking_mmps2: int = 20_000
    front_bumpers: int = 0x01
    back_bumpers: int = 0x02
    still_ms: int = 50
    least_us: int = 1000
    most_us: int = 2000
    us_per_s: int = 2000
    kind: Kind = Kind.SIDES
    arm_mm: int = 200
    fastest_mmps: int = 32_767
    left_bumpers: int = 0x04
    right_bumpers: int = 0x08


class _State(ctypes.Structure):
    _fields_ = [
        ("wheels_mmps", ctypes.c_int16 * WHEELS),
        ("axes", ctypes.c_int16 * AXES),
        ("servos_us", ctypes.c_uint16 * AXES),
        ("moving", ctypes.c_uint8),
        ("timed_out", ctypes.c_uint8),
        ("damaged", ctypes.c_uint16),
    ]


class _Frame(ctypes.Structure):
    _fields_ = [
        ("type", ctypes.c_uint8),
        ("axis", ctypes.c_uint8),
        ("verdict", ctypes.c_uint8),
        ("sequence", ctypes.c_uint16),
        ("ttl_ms", ctypes.c_uint16),
        ("session", ctypes.c_uint16),
        ("turn", ctypes.c_uint32),
        ("time_ms", ctypes.c_uint32),
        ("left_mmps", ctypes.c_int16),
        ("right_mmps", ctypes.c_int16),
        ("linear_mmps", ctypes.c_int16),
        ("lateral_mmps", ctypes.c_int16),
        ("angular_mradps", ctypes.c_int16),
        ("position", ctypes.c_int16),
    ]


def build(firmware: Path = FIRMWARE, folder: Path | None = None) -> Path:
    """Build the library if these sources have changed; raises with the compiler's output."""
    into = [] if folder is None else [str(folder)]
    built = subprocess.run(
        ["sh", ".make/firmware.sh", "library", str(firmware), *into],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return Path(built.stdout.splitlines()[-1])


@cache
def load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    library.wax_new.restype = ctypes.c_void_p
    library.wax_power.restype = ctypes.c_int16
    return library


@cache
def library() -> ctypes.CDLL:
    """Return the core of this tree, or the one that counts its branches."""
    counting = os.environ.get("WAX_FIRMWARE_LIBRARY")
    return load(Path(counting) if counting else build())


def power(mmps: int, full_mmps: int, least: int) -> int:
    """Return the power for a wheel's speed."""
    return int(library().wax_power(mmps, full_mmps, least))


def battery(numbers: list[int], full_scale: int, full_mv: int) -> list[int]:
    """Return the voltage after each of these readings of an analog input."""
    given = (ctypes.c_uint16 * len(numbers))(*numbers)
    found = (ctypes.c_uint16 * len(numbers))()
    library().wax_battery(full_scale, full_mv, given, len(numbers), found)
    return list(found)


class Core:
    """One robot; every method takes the time of its clock, whose lowest 32 bits count."""

    def __init__(
        self,
        settings: Settings | None = None,
        now_ms: int = 0,
        core: ctypes.CDLL | None = None,
    ) -> None:
        self._core = core or library()
        self._settings = settings or Settings()
        self._robot = self._new(now_ms)
        self._state = _State()
        self._report = (ctypes.c_uint8 * 64)()

    def __del__(self) -> None:
        self._core.wax_delete(self._robot)

    def reset(self, now_ms: int) -> None:
        """Restart the board."""
        self._core.wax_delete(self._robot)
        self._robot = self._new(now_ms)

    def push(self, data: bytes) -> None:
        """Give it bytes without asking for frames."""
        for octet in data:
            self._core.wax_push(self._robot, octet)

    def next(self, now_ms: int) -> tuple[Frame, Verdict] | None:
        """Return the next whole frame among the bytes pushed, with its verdict."""
        found = _Frame()
        if not self._core.wax_next(self._robot, _clock(now_ms), ctypes.byref(found)):
            return None
        return _frame(found), Verdict(found.verdict)

    def hear(self, data: bytes, now_ms: int) -> list[tuple[Frame, Verdict]]:
        """Give it bytes as the sketch does; return its verdict on each frame in them."""
        found = (_Frame * (len(data) + 1))()
        count = self._core.wax_hear(self._robot, data, len(data), _clock(now_ms), found)
        return [(_frame(one), Verdict(one.verdict)) for one in found[:count]]

    def tick(
        self, now_ms: int, *, battery_mv: int = 0, bumpers: int = 0, ticks: tuple[int, int] = (0, 0)
    ) -> None:
        self._core.wax_tick(self._robot, _clock(now_ms), battery_mv, bumpers, *ticks)

    def report(self, now_ms: int) -> bytes:
        """Return the report that is due, or nothing."""
        size = self._core.wax_report(self._robot, _clock(now_ms), self._report)
        return bytes(self._report[:size])

    @property
    def wheels_mmps(self) -> tuple[int, ...]:
        """The speed of each wheel that its base has."""
        return tuple(self._look().wheels_mmps)[: self._settings.kind.wheels]

    @property
    def axes(self) -> list[int]:
        return list(self._look().axes)

    @property
    def servos_us(self) -> list[int]:
        return list(self._look().servos_us)

    @property
    def moving(self) -> bool:
        return bool(self._look().moving)

    @property
    def timed_out(self) -> bool:
        return bool(self._look().timed_out)

    @property
    def damaged(self) -> int:
        return int(self._look().damaged)

    def _new(self, now_ms: int) -> ctypes.c_void_p:
        own = self._settings
        return ctypes.c_void_p(
            self._core.wax_new(
                own.acceleration_mmps2,
                own.braking_mmps2,
                own.front_bumpers,
                own.back_bumpers,
                own.still_ms,
                own.least_us,
                own.most_us,
                own.us_per_s,
                own.kind,
                own.arm_mm,
                own.fastest_mmps,
                own.left_bumpers,
                own.right_bumpers,
                _clock(now_ms),
            )
        )

    def _look(self) -> _State:
        self._core.wax_state(self._robot, ctypes.byref(self._state))
        return self._state


def _clock(now_ms: int) -> ctypes.c_uint32:
    return ctypes.c_uint32(now_ms & 0xFFFF_FFFF)


def _frame(found: _Frame) -> Frame:
    bodies: dict[int, Callable[[], Body]] = {
        0x00: lambda: HelloBody(found.session),
        0x01: lambda: DriveBody(found.left_mmps, found.right_mmps),
        0x02: lambda: AxisBody(found.axis, found.position),
        0x03: StopBody,
        0x04: lambda: MoveBody(found.linear_mmps, found.lateral_mmps, found.angular_mradps),
    }
    return Frame(
        bodies[found.type](),
        sequence=found.sequence,
        turn=found.turn,
        ttl_ms=found.ttl_ms,
        time_ms=found.time_ms,
    )
