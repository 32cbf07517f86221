"""A clock that is turned by hand, and a robot's board at the end of a real serial line."""

from __future__ import annotations

import os
import select
import time
import tty
from typing import TYPE_CHECKING

import pytest

from wax.robot.serial.frames import Decoder, Drive, Stop

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from wax.robot.serial.frames import Body, Frame


class FakeClock:
    """Stands still until it is turned, or until somebody waits on it."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return 0

    def wait(self, pause_s: float) -> bool:
        """Let so much time pass at once."""
        self.time_s += pause_s
        return False


class Board:
    """The robot's end of a serial line, a real pseudo-terminal that can be unplugged.

    `path` is what the driver opens; it is there while the board is plugged in.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / "robot"
        self.heard = b""
        self._master: int | None = None
        self._slave: int | None = None

    def plug(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path.symlink_to(os.ttyname(self._slave))
        self.heard = b""

    def unplug(self) -> None:
        """Hang up; safe to call twice."""
        if self._master is None or self._slave is None:
            return
        self.path.unlink()
        os.close(self._slave)
        os.close(self._master)
        self._master = self._slave = None

    def say(self, data: bytes) -> None:
        assert self._master is not None
        os.write(self._master, data)

    def listen(self, seconds: float) -> bytes:
        """Give what comes within so many seconds."""
        before = len(self.heard)
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0:
            self._take(left_s)
        return self.heard[before:]

    def until(self, enough: Callable[[], bool], within_s: float = 5.0) -> None:
        """Listen until what was heard is enough; fails when it takes too long."""
        end_s = time.monotonic() + within_s
        while not enough():
            left_s = end_s - time.monotonic()
            assert left_s > 0, f"only {self.heard!r} came"
            self._take(left_s)

    def frames(self) -> list[Frame]:
        """Decode what was heard; fails on damage."""
        decoder = Decoder()
        found = decoder.feed(self.heard)
        assert decoder.errors == 0
        return found

    def said(self, body: Body) -> bool:
        return any(frame.body == body for frame in self.frames())

    def moves(self, dialect: str) -> bool:
        """Tell whether what was heard would move a robot."""
        if dialect == "bytes":
            return any(octet in b"FBLRGIHJ" for octet in self.heard)
        return any(isinstance(frame.body, Drive) for frame in self.frames())

    def stands(self, dialect: str) -> bool:
        """Tell whether the last that was heard is a stop."""
        if dialect == "bytes":
            return self.heard.endswith(b"S")
        return isinstance(self.frames()[-1].body, Stop)

    def _take(self, timeout_s: float) -> None:
        assert self._master is not None
        ready, _, _ = select.select([self._master], [], [], timeout_s)
        if ready:
            self.heard += os.read(self._master, 4096)


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
