"""A manual clock, and a robot's board at the end of a real serial line."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
import tty
from typing import TYPE_CHECKING

import pytest
from tests.firmware.core import Core, Kind, Settings
from tests.turned_clock import TurnedClock

from wax.robot.serial.frames import Decoder, DriveBody, MoveBody, StopBody

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from wax.robot.serial.frames import Body, Frame


class FakeClock(TurnedClock):
    """A clock that stands still until it is turned or waited on."""

    def wait(self, pause_s: float) -> bool:
        """Advance by `pause_s` at once."""
        self.time_s += pause_s
        return False


class Board:
    """The robot's end of a serial line, a real pseudo-terminal that can be unplugged.

    The real firmware's core runs behind it. The driver opens `path`, which exists while the board
    is plugged in. While `deaf` it reads nothing, while `mute` it writes no reports.
    """

    def __init__(self, folder: Path, kind: Kind = Kind.SIDES) -> None:
        self.path = folder / "robot"
        self.deaf = self.mute = False
        self.core = Core(Settings(kind=kind), _now_ms())
        self._lock = threading.Lock()
        self._heard = b""
        self._frames: list[Frame] = []
        self._decoder = Decoder()
        self._ends: tuple[int, int] | None = None
        self._thread: threading.Thread | None = None

    def plug(self) -> None:
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self.forget()
        self._decoder = Decoder()
        self._ends = master, slave
        self._thread = threading.Thread(target=self._live, args=(master,))
        self._thread.start()
        self.path.symlink_to(os.ttyname(slave))

    def unplug(self) -> None:
        """Unplug the board; safe to call twice."""
        if self._ends is None or self._thread is None:
            return
        self.path.unlink()
        (master, slave), self._ends = self._ends, None
        self._thread.join()
        os.close(slave)
        os.close(master)

    @property
    def heard(self) -> bytes:
        with self._lock:
            return self._heard

    def forget(self) -> None:
        with self._lock:
            self._heard = b""
            self._frames = []

    def say(self, data: bytes) -> None:
        assert self._ends is not None
        with contextlib.suppress(BlockingIOError):
            os.write(self._ends[0], data)

    def restart(self) -> None:
        """Restart it, as after a dip of its supply."""
        with self._lock:
            self.core.reset(_now_ms())

    def listen(self, seconds: float) -> bytes:
        """Return what arrives within `seconds`."""
        before = len(self.heard)
        time.sleep(seconds)
        return self.heard[before:]

    def until(self, enough: Callable[[], bool], within_s: float = 5.0) -> None:
        """Wait until `enough` holds; fail after `within_s`."""
        end_s = time.monotonic() + within_s
        while not enough():
            assert time.monotonic() < end_s, f"only {self.heard!r} came"
            time.sleep(0.001)

    def frames(self) -> list[Frame]:
        """Return the frames so far; fail if any is damaged."""
        with self._lock:
            assert self._decoder.errors == 0
            return list(self._frames)

    def said(self, body: Body) -> bool:
        return any(frame.body == body for frame in self.frames())

    def moves(self, dialect: str) -> bool:
        """Return whether anything received moves a robot."""
        if dialect == "bytes":
            return any(octet in b"FBLRGIHJ" for octet in self.heard)
        return any(isinstance(frame.body, DriveBody | MoveBody) for frame in self.frames())

    def stands(self, dialect: str) -> bool:
        """Return whether a stop was received last."""
        if dialect == "bytes":
            return self.heard.endswith(b"S")
        frames = self.frames()
        return bool(frames) and isinstance(frames[-1].body, StopBody)

    def _live(self, master: int) -> None:
        while self._ends is not None:
            ready, _, _ = select.select([] if self.deaf else [master], [], [], 0.002)
            data = os.read(master, 4096) if ready else b""
            with self._lock:
                self._heard += data
                self._frames += self._decoder.feed(data)
                now_ms = _now_ms()
                self.core.hear(data, now_ms)
                self.core.tick(now_ms)
                report = self.core.report(now_ms)
            if report and not self.mute:
                with contextlib.suppress(BlockingIOError):
                    os.write(master, report)


def _now_ms() -> int:
    return int(time.monotonic() * 1000.0)


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    """Plug a board in."""
    board = Board(tmp_path)
    board.plug()
    yield board
    board.unplug()
