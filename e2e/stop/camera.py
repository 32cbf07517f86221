"""A camera of the tests, an ordinary plug-in that freezes, fails, or blocks its server on request.

It is controlled by files in the folder that the environment names, or in the server's state folder:
while ``freeze`` exists no picture comes, while ``pull`` exists reading fails as if a USB plug were
out, and ``block`` contains for how many seconds to block the event loop, once.
"""

from __future__ import annotations

import asyncio
import os
import sys
import threading
import time
from collections import deque
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, Self

from e2e.harness.wait import until
from wax.capture.testcard import TestCardVideo
from wax.errors import SourceError

if TYPE_CHECKING:
    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.video import VideoSettings

CONTROL: Final = "WAX_FAULTS_CAMERA"
SOURCE: Final = f"{__name__}:Camera"
PULLED: Final = "The plug is out."
LATE_S: Final = 0.5
"""Later than the shipped age at which the robot slows down."""
_LOOK_S: Final = 0.01
_LONGEST_READ_S: Final = 1.9
"""A source may block for 2 s."""


class Camera(TestCardVideo):
    """The test card, until it is frozen."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        super().__init__(settings, clock)
        self._folder = Path(os.environ.get(CONTROL) or os.environ["XDG_STATE_HOME"])
        self._newest: Picture | None = None
        self._loops: list[asyncio.AbstractEventLoop] = []

    def open(self) -> None:
        self._check()
        super().open()

    def read(self) -> Picture:
        """Return the next picture; while frozen, the newest again, with its old capture time."""
        self._check()
        self._loops = self._loops or _running_loops()
        self._block()
        since_s = time.monotonic()
        while (self._folder / "freeze").exists() and self._newest is not None:
            # The reader uses CLOCK_MONOTONIC, which stands still while the machine sleeps.
            asleep_s = self._clock.now_s() - time.monotonic()
            self._note("frozen", self._newest.captured_s - asleep_s)
            self._block()
            time.sleep(_LOOK_S)
            if time.monotonic() - since_s > _LONGEST_READ_S:
                return self._newest
        self._newest = super().read()
        return self._newest

    def _check(self) -> None:
        if (self._folder / "pull").exists():
            raise SourceError(PULLED)

    def _block(self) -> None:
        order = self._folder / "block"
        if not order.exists():
            return
        seconds = float(order.read_text(encoding="utf-8"))
        order.unlink()
        for loop in self._loops:
            loop.call_soon_threadsafe(self._hang, seconds)

    def _hang(self, seconds: float) -> None:
        self._note("blocked", time.monotonic())
        time.sleep(seconds)

    def _note(self, name: str, at_s: float) -> None:
        """Write a time atomically."""
        half = self._folder / f"{name}.half"
        half.write_text(repr(at_s), encoding="utf-8")
        half.rename(self._folder / name)


class LateCamera(TestCardVideo):
    """The test card of `LATE_S` ago, with its true capture time."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        super().__init__(settings, clock)
        self._under_way: deque[Picture] = deque()

    def read(self) -> Picture:
        """Return the newest picture that is late enough; a busy machine skips some.

        Holding a fixed number of pictures back would delay them more when fewer arrive in a second.
        """
        while True:
            newest = super().read()
            self._under_way.append(newest)
            arrived: Picture | None = None
            while self._under_way[0].captured_s <= newest.captured_s - LATE_S:
                arrived = self._under_way.popleft()
            if arrived is not None:
                return arrived

    def close(self) -> None:
        self._under_way.clear()
        super().close()


def _running_loops() -> list[asyncio.AbstractEventLoop]:
    """Find the event loop in the main thread's frames; objects frozen by gc are in no list."""
    frame = sys._current_frames().get(threading.main_thread().ident or 0)
    loops: list[asyncio.AbstractEventLoop] = []
    while frame is not None:
        owner = frame.f_locals.get("self")
        if isinstance(owner, asyncio.AbstractEventLoop) and owner not in loops:
            loops.append(owner)
        frame = frame.f_back
    return loops


class Control:
    """Controls the camera: `with Control() as control:`. It serves as a `rig` in `Fault`."""

    def __init__(self) -> None:
        self._temporary = TemporaryDirectory(prefix="wax-camera-")
        self.folder = Path(self._temporary.name)
        self.settings: dict[str, Any] = {"video": {"source": SOURCE}}
        self.environment = {CONTROL: str(self.folder)}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._temporary.cleanup()

    async def block(self, seconds: float) -> float:
        """Block the event loop; return when that began, on CLOCK_MONOTONIC."""
        order = self.folder / "block.half"
        order.write_text(str(seconds), encoding="utf-8")
        order.rename(self.folder / "block")
        return await self._moment("blocked")

    async def freeze(self) -> float:
        """Freeze the camera; return when its last picture was captured."""
        # The camera may have noted an earlier picture before it was thawed.
        (self.folder / "frozen").unlink(missing_ok=True)
        (self.folder / "freeze").touch()
        return await self._moment("frozen")

    def thaw(self) -> None:
        (self.folder / "freeze").unlink(missing_ok=True)

    async def _moment(self, name: str) -> float:
        noted = self.folder / name
        await until(noted.exists, f"the camera says {name}", within_s=5, every_s=0.005)
        at_s = float(noted.read_text(encoding="utf-8"))
        noted.unlink(missing_ok=True)
        return at_s
