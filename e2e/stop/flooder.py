"""A viewer without the turn who sends commands as fast as possible, in a process of its own."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import until
from e2e.measure.errors import MeasureError
from e2e.stop.operator import RawOperator
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from multiprocessing.connection import Connection

    from e2e.stop.fault import Scene

RATE_HZ: Final = 10_000.0
"""The rate offered; the viewer's budget holds back the rest."""
LEAST_HZ: Final = 500.0
"""The least rate that must really have been sent, ten times a page's."""
WAYS: Final = ("operator, channel", "operator, HTTP", "observer, channel", "observer, HTTP")
_TICK_S: Final = 0.005
_MAX_WAITING_BYTES: Final = 256
"""As in a page (`link/peer.ts`): with more in the channel's buffer, messages would only wait."""


class Flood:
    """The pipe to the flooder's process, and an observer."""

    def __init__(self, pipe: Connection[Any, Any], observer: RawOperator) -> None:
        self._pipe = pipe
        self.observer = observer

    async def asked(self, what: str) -> float:
        """Tell it to ``stop``, which presses Stop, or to ``end``; return its answer."""
        self._pipe.send(what)
        return await self.says()

    async def says(self) -> float:
        if not await asyncio.to_thread(self._pipe.poll, 20):
            raise MeasureError("the flooder says nothing")
        return float(self._pipe.recv())


@asynccontextmanager
async def flooded(scene: Scene, *, rate_hz: float = RATE_HZ) -> AsyncIterator[None]:
    """Flood the server's command channel; raises `MeasureError` if that was no flood."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(scene.stage.server.url, rate_hz, theirs))
    async with RawOperator(scene.stage.server) as observer:
        process.start()
        try:
            flood = scene.prop = Flood(ours, observer)
            await flood.says()
            yield
            sent_hz = await flood.asked("end")
        finally:
            process.kill()
            process.join()
    if sent_hz < LEAST_HZ:
        raise MeasureError(f"the flood was of {sent_hz:.0f} messages a second only")


async def press_stop(ways: Sequence[str], scene: Scene) -> float:
    """Press Stop, each time in the next of the ways; return when."""
    flood: Flood = scene.prop
    who, _, how = ways[scene.trials % len(ways)].partition(", ")
    if who == "flooder":
        since_s = await flood.asked("stop")
    else:
        since_s = time.monotonic()
        peer = scene.operator if who == "operator" else flood.observer
        if how == "HTTP":
            await peer.press_stop()
        else:
            peer.send(type="stop")
    await until(
        lambda: scene.operator.stopped is not None, "the operator is told of the stop", every_s=0.01
    )
    return since_s


async def release_stop(scene: Scene) -> None:
    stop = scene.operator.stopped
    assert stop is not None
    scene.operator.let_go()
    await asyncio.sleep(0.04)
    scene.operator.release(stop)
    await until(lambda: scene.operator.stopped is None, "the stop is released", every_s=0.01)


def _work(url: str, rate_hz: float, pipe: Connection[Any, Any]) -> None:
    asyncio.run(_flood(url, rate_hz, pipe))


async def _flood(url: str, rate_hz: float, pipe: Connection[Any, Any]) -> None:
    """Send 0 when it begins, then when each Stop was pressed, then how many it sent a second."""
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
        ended = asyncio.Event()

        def asked() -> None:
            if pipe.recv() == "end":
                ended.set()
                return
            pressed_s = time.monotonic()
            peer.send(type="stop")
            pipe.send(pressed_s)

        asyncio.get_running_loop().add_reader(pipe.fileno(), asked)
        pipe.send(0.0)
        start_s = time.monotonic()
        while not ended.is_set():
            owed = int((time.monotonic() - start_s) * rate_hz)
            allowed = min(owed, sent + int(rate_hz * _TICK_S * 4))
            pour()
            await asyncio.sleep(_TICK_S)
        waiting = peer.drive.bufferedAmount / len(row)
        pipe.send((sent - waiting) / (time.monotonic() - start_s))
