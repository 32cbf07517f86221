"""The ear: what a sound device plays, in blocks of 10 ms, whatever page or browser plays it.

The device is a null sink of PulseAudio of our own; its monitor carries what a cable to the
loudspeaker would, so that the whole path from the jitter buffer to the device is included.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import tempfile
import time
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from weakref import WeakSet

import numpy as np

from e2e.harness.child import kill
from e2e.measure.errors import MeasureError, NotRunError
from wax.clock import SystemClock

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

    from numpy.typing import NDArray

RATE_HZ: Final = 48_000
BLOCK: Final = 480
BLOCK_MS: Final = 10.0
_FRAME_BYTES: Final = 8
"""A sample of each channel."""
_TONE_HZ: Final = 300
_BURST_HZ: Final = 1000
_STARTS_WITHIN_S: Final = 10.0
SILENT: Final = 0.001
_RECENT: Final = 100
_APART_MS: Final = 100.0
"""Samples that come this much later than expected in their row begin a new row."""

_LATENCY_MS: Final = 2
"""The device plays in steps of this length, as the recorder asks."""


class Block(NamedTuple):
    """10 ms of played sound: Unix time in ms, loudness, amplitudes of the card's two tones."""

    start_ms: float
    rms: float
    tone: float
    burst: float


class Pace:
    """Tells when each block of an even row was played, from when its samples arrived.

    They arrive in fragments, but never before they were played: the quickest of the last second
    counts.
    """

    def __init__(self) -> None:
        self._begin_ms = 0.0
        self._blocks = 0
        self._late_ms: list[float] = []

    def at_ms(self, came_ms: float) -> float:
        """Return when the block that arrived at `came_ms` began to be played."""
        late_ms = came_ms - self._begin_ms - BLOCK_MS * (self._blocks + 1)
        if not self._late_ms or abs(late_ms - min(self._late_ms)) > _APART_MS:
            self._begin_ms, self._blocks, self._late_ms = came_ms - BLOCK_MS, 0, []
            late_ms = 0.0
        self._late_ms = [*self._late_ms[-_RECENT:], late_ms]
        begin_ms = self._begin_ms + BLOCK_MS * self._blocks + min(self._late_ms)
        self._blocks += 1
        return begin_ms


class Tap:
    """What one listener has heard and not yet read; `recorded` are its samples, ``(n, 2)``."""

    def __init__(self, *, records: bool = False) -> None:
        self.heard: list[Block] = []
        self.recorded: list[NDArray[np.float32]] | None = [] if records else None
        self._sounds = asyncio.Event()
        self.first_ms: float | None = None

    def take(self) -> list[Block]:
        """Return what was heard since the last call."""
        heard, self.heard = self.heard, []
        return heard

    async def hears(self, within_s: float) -> bool:
        """Wait until something sounds; return whether it did in time."""
        with suppress(TimeoutError):
            await asyncio.wait_for(self._sounds.wait(), within_s)
        return self._sounds.is_set()

    def add(self, block: Block, samples: NDArray[np.float32]) -> None:
        self.heard.append(block)
        if self.recorded is not None:
            self.recorded.append(samples)
        if block.rms > SILENT and self.first_ms is None:
            self.first_ms = block.start_ms
            self._sounds.set()


class Ear:
    """`variables` is the environment for programs that the ear hears."""

    def __init__(self, variables: dict[str, str]) -> None:
        self.variables = variables
        self._taps: WeakSet[Tap] = WeakSet()
        self._pace = Pace()
        self._left = b""
        at = np.arange(BLOCK) / RATE_HZ
        self._waves = [np.exp(-2j * np.pi * hz * at) for hz in (_TONE_HZ, _BURST_HZ)]

    def tap(self, *, records: bool = False) -> Tap:
        """Return a tap of all that is heard from now on; closing it ends it."""
        tap = Tap(records=records)
        self._taps.add(tap)
        return tap

    def hear(self, data: bytes, came_ms: float) -> None:
        """Receive samples, of which the last arrived at `came_ms`.

        They are 32-bit floats, left and right in turn. The device delivers what it plays when it
        begins to play it, in steps of 2 ms.
        """
        data = self._left + data
        size = _FRAME_BYTES * BLOCK
        count = len(data) // size
        self._left = data[count * size :]
        after_ms = len(self._left) / (_FRAME_BYTES * RATE_HZ) * 1000
        for number in range(count):
            flat = np.frombuffer(data, np.float32, 2 * BLOCK, number * size)
            later_ms = BLOCK_MS * (count - 1 - number) + after_ms
            at_ms = self._pace.at_ms(came_ms - later_ms) + _LATENCY_MS
            self._tell(flat.reshape(BLOCK, 2), at_ms)

    def _tell(self, both: NDArray[np.float32], at_ms: float) -> None:
        if not self._taps:
            return
        samples = both.mean(axis=1)
        tone, burst = (2 * abs(complex(np.dot(samples, wave))) / BLOCK for wave in self._waves)
        rms = float(np.sqrt(np.mean(samples**2)))
        block = Block(round(at_ms, 2), round(rms, 4), round(tone, 4), round(burst, 4))
        for tap in self._taps:
            tap.add(block, both)

    async def listen(self, stream: asyncio.StreamReader) -> None:
        clock = SystemClock()
        while data := await stream.read(65_536):
            self.hear(data, clock.wall_ms())


@asynccontextmanager
async def open_ear() -> AsyncIterator[Ear]:
    """Run a sound device of our own. Raises `NotRunError` or `MeasureError`."""
    for program, package in (("pulseaudio", "pulseaudio"), ("parec", "pulseaudio-utils")):
        if shutil.which(program) is None:
            raise NotRunError(f"there is no {program}; install the package {package}")
    # In a folder of its own, not the caller's, since a socket's path has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="ear-") as folder:
        socket = Path(folder) / "pulse"
        variables = {"PULSE_SERVER": f"unix:{socket}", "PULSE_RUNTIME_PATH": folder}
        quiet: dict[str, Any] = {
            "env": {**os.environ, **variables, "HOME": folder},
            "stderr": asyncio.subprocess.DEVNULL,
        }
        # Without the recorder it ends by itself, even if this process could not end it.
        device = await asyncio.create_subprocess_exec(
            *("pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=5", "--realtime=no"),
            *("-L", f"module-native-protocol-unix socket={socket} auth-anonymous=1"),
            *("-L", f"module-null-sink sink_name=ear rate={RATE_HZ} channels=2"),
            **quiet,
        )
        recorder, listening = None, None
        try:
            await _there(socket, device)
            recorder = await asyncio.create_subprocess_exec(
                *("parec", "--raw", "--device=ear.monitor", "--format=float32le", "--channels=2"),
                *(f"--rate={RATE_HZ}", f"--latency-msec={_LATENCY_MS}"),
                stdout=asyncio.subprocess.PIPE,
                **quiet,
            )
            assert recorder.stdout is not None
            ear = Ear(variables)
            listening = asyncio.create_task(ear.listen(recorder.stdout), name="ear")
            yield ear
        finally:
            await kill(recorder)
            await kill(device)
            if listening is not None:
                await listening  # until the pipe closes


async def _there(socket: Path, device: Process) -> None:
    until_s = time.monotonic() + _STARTS_WITHIN_S
    while not os.path.exists(socket):  # noqa: ASYNC240, PTH110  # another process makes it
        if device.returncode is not None or time.monotonic() > until_s:
            raise MeasureError("PulseAudio does not start")
        await asyncio.sleep(0.05)
