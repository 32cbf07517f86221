"""Drivers as nobody should write them; each is wrong in one way."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from tests.idle_robot import IdleRobot

from wax.capture.source import Picture
from wax.driver.interface import Limits, RobotState

if TYPE_CHECKING:
    from wax.capture.source import VideoSource
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.driver.interface import Twist

_FOR_EVER_S = 3600.0


def _hang_with_interpreter() -> None:
    """Sleep in C without releasing the GIL, as a bad extension does."""
    ctypes.PyDLL(None).sleep(int(_FOR_EVER_S))


class Good(IdleRobot):
    """The base of the others."""

    kind: Any = "good"
    limits: Any = Limits(0.6, 1.5, ttl_s=0.2)

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self._clock = clock


class RaisesInConstructor(Good):
    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        raise OSError("no bus")


class RubbishLimits(Good):
    limits = (0.6, 1.5)


class RubbishKind(Good):
    kind = b"\xff"


class RaisesInLimits(Good):
    @property
    def limits(self) -> Limits:  # type: ignore[override]  # it computes them
        raise OSError("no bus")


class RaisesInOpen(Good):
    def open(self) -> None:
        raise OSError("no bus")


class HangsInOpen(Good):
    def open(self) -> None:
        time.sleep(_FOR_EVER_S)


class RaisesInApply(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        raise OSError("no bus")


class HangsInApply(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        time.sleep(_FOR_EVER_S)


class HangsWithInterpreter(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        _hang_with_interpreter()


class Sees(Good):
    """A camera that works."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _Eye(settings, clock)


class RaisesInStop(Sees):
    def stop(self, turn: int) -> None:
        raise OSError("no bus")


class HangsInStop(Sees):
    def stop(self, turn: int) -> None:
        time.sleep(_FOR_EVER_S)


class RaisesInState(Good):
    def state(self) -> RobotState:
        raise OSError("no bus")


class RubbishState(Good):
    def state(self) -> str:  # type: ignore[override]  # somebody's driver
        return "fine, thanks"


class HangsInState(Good):
    def state(self) -> RobotState:
        time.sleep(_FOR_EVER_S)
        raise AssertionError


class HangsInClose(Good):
    """Its process also exits, so `close` hangs again and again."""

    def apply(self, twist: Twist, turn: int) -> None:
        sys.exit(4)

    def close(self) -> None:
        time.sleep(_FOR_EVER_S)


class LeaksThreads(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        for _ in range(50):
            threading.Thread(target=time.sleep, args=(_FOR_EVER_S,), daemon=True).start()


class LeaksMemory(Good):
    kept: list[bytes] = []  # noqa: RUF012 - that is what is wrong with it

    def apply(self, twist: Twist, turn: int) -> None:
        self.kept.append(b"x" * (8 << 20))


class LeaksFiles(Good):
    kept: list[int] = []  # noqa: RUF012 - that is what is wrong with it

    def apply(self, twist: Twist, turn: int) -> None:
        self.kept.extend(os.open(os.devnull, os.O_RDONLY) for _ in range(100))


class Exits(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        os._exit(3)


class KillsItself(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        os.kill(os.getpid(), signal.SIGKILL)


class PrintsMegabytes(Good):
    def apply(self, twist: Twist, turn: int) -> None:
        print("x" * 100 * 1024, flush=True)  # noqa: T201
        print("\n".join("y" * 80 for _ in range(1000)), file=sys.stderr)  # noqa: T201


class TakesSignals(Good):
    """Ignores the signals to end, and hangs."""

    def open(self) -> None:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGALRM, signal.SIGHUP):
            signal.signal(number, lambda *_: None)

    def apply(self, twist: Twist, turn: int) -> None:
        while True:
            time.sleep(_FOR_EVER_S)


# --- cameras ------------------------------------------------------------------------------------


class _Eye:
    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._shape = (settings.height * 3 // 2, settings.width)
        self._clock = clock

    def open(self) -> None: ...

    def read(self) -> Any:
        time.sleep(0.05)
        return Picture(np.zeros(self._shape, np.uint8), self._clock.now_s(), within_s=0.0)

    def close(self) -> None: ...


class CameraRaises(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        raise OSError("no lens")


class CameraHangs(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        time.sleep(_FOR_EVER_S)
        raise AssertionError


class CameraIsNone(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> Any:
        return "no camera at all"


class _Odd(_Eye):
    def read(self) -> Any:
        picture = super().read()
        return Picture(np.zeros((7, 5, 3), np.uint8), picture.captured_s)


class CameraIsOdd(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _Odd(settings, clock)


class _Exits(_Eye):
    def read(self) -> Any:
        os._exit(5)


class CameraExits(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _Exits(settings, clock)


class _Locks(_Eye):
    def read(self) -> Any:
        _hang_with_interpreter()


class CameraLocks(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _Locks(settings, clock)


class _Leaks(_Eye):
    def read(self) -> Any:
        for _ in range(100):
            threading.Thread(target=time.sleep, args=(_FOR_EVER_S,), daemon=True).start()
        return super().read()


class CameraLeaks(Good):
    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _Leaks(settings, clock)
