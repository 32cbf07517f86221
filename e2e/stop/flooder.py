"""A viewer without the turn who sends commands as fast as possible, in a process of its own.

``python -m e2e.stop.flooder URL RATE_HZ`` writes an empty line when it begins, floods until its
standard input ends, and then writes as JSON how much it really sent. For each line that it reads
meanwhile it presses Stop, on its own reliable channel, and writes when: s of `time.monotonic`.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from asyncio.subprocess import PIPE, Process
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import MeasureError
from e2e.measure.suite import ROOT
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

_TICK_S: Final = 0.005
_MAX_WAITING_BYTES: Final = 256
"""As in a page (`link/peer.ts`): more in the channel's buffer would only wait longer."""


class Flood:
    """Controls the flooder's process; `end` returns what was sent."""

    def __init__(self, process: Process) -> None:
        self._process = process

    async def press_stop(self) -> float:
        """Let the flooder press Stop; return when, in s of `time.monotonic`."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(b"stop\n")
        said = await asyncio.wait_for(self._process.stdout.readline(), 20)
        if not said:
            raise MeasureError("the flood ended too soon; its last words are above")
        return float(said)

    async def end(self) -> dict[str, Any]:
        assert self._process.stdin is not None
        self._process.stdin.close()
        said, _ = await asyncio.wait_for(self._process.communicate(), 20)
        found = json.loads(said)
        if not isinstance(found, dict):
            raise MeasureError("the flood did not say what it sent")
        return found


@asynccontextmanager
async def flooding(url: str, rate_hz: float) -> AsyncIterator[Flood]:
    """Flood the server's command channel during the block."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "e2e.stop.flooder",
        url,
        str(rate_hz),
        stdin=PIPE,
        stdout=PIPE,
        cwd=ROOT,
    )
    assert process.stdout is not None
    try:
        if not await asyncio.wait_for(process.stdout.readline(), 20):
            raise MeasureError("the flood ended before it began; its last words are above")
        yield Flood(process)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def _flood(url: str, rate_hz: float) -> dict[str, float]:
    async with Operator(url) as peer:
        row = peer.row(1, turn=peer.turn, linear=-1.0, held=True)
        sent = allowed = 0

        def pour() -> None:
            nonlocal sent
            while sent < allowed and peer.drive.bufferedAmount <= _MAX_WAITING_BYTES:
                peer.drive.send(row)
                sent += 1

        peer.drive.bufferedAmountLowThreshold = _MAX_WAITING_BYTES // 2
        peer.drive.on("bufferedamountlow", pour)
        print(flush=True)
        loop = asyncio.get_running_loop()
        ended = asyncio.create_task(asyncio.to_thread(_listen, loop, partial(_press, peer)))
        start_s = time.monotonic()
        while not ended.done():
            owed = int((time.monotonic() - start_s) * rate_hz)
            allowed = min(owed, sent + int(rate_hz * _TICK_S * 4))
            pour()
            await asyncio.sleep(_TICK_S)
        took_s = time.monotonic() - start_s
        waiting = peer.drive.bufferedAmount / len(row)
    return {"sent_hz": (sent - waiting) / took_s, "wanted_hz": rate_hz, "took_s": took_s}


def _press(peer: Operator) -> None:
    pressed_s = time.monotonic()
    peer.say(type="stop")
    print(pressed_s, flush=True)


def _listen(loop: asyncio.AbstractEventLoop, press: Callable[[], None]) -> None:
    """Press Stop for each line of standard input, until it ends; in a thread of its own."""
    for _ in sys.stdin:
        loop.call_soon_threadsafe(press)


if __name__ == "__main__":
    print(json.dumps(asyncio.run(_flood(sys.argv[1], float(sys.argv[2])))))
