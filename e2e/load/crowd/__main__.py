"""``python -m e2e.load.crowd URL HOW SLOW``: hold a crowd until the input ends.

HOW is ``wax``, ``stock`` or ``janus``; the first SLOW viewers are behind a modem each. Each line of
the input is a verb and a number, answered by a line with a `Sample`.
"""

from __future__ import annotations

import asyncio
import sys
import time
from functools import partial
from typing import TYPE_CHECKING, Final

import aiohttp

from e2e.load.crowd.modem import put_behind
from e2e.load.crowd.sample import Sample, ViewerCounts
from e2e.load.crowd.viewers import JanusViewer, StockViewer
from wax.client import Client
from wax.errors import WaxError
from wax.rtc import private

if TYPE_CHECKING:
    from collections.abc import Callable

    Viewer = Client | StockViewer

JOINING_AT_ONCE: Final = 4
CONNECT_TIMEOUT_S: Final = 20.0


class SmallPicture(Client):
    """Watches 640x480."""

    size = "640x480"


KINDS: Final[dict[str, Callable[..., Viewer]]] = {
    "wax": SmallPicture,
    "stock": StockViewer,
    "janus": JanusViewer,
}


class Viewers:
    """All viewers; the first `slow` of them are behind a modem."""

    def __init__(self, url: str, how: str, slow: int) -> None:
        self._make = partial(KINDS[how], url)
        self._slow = slow
        self._here: list[Viewer] = []

    async def answer(self, verb: str, number: int) -> Sample:
        """Hold `number` viewers (``hold``), or let so many join and leave (``cycle``); count."""
        try:
            if verb == "hold":
                await self.hold(number)
            elif verb == "cycle":
                await self._cycle(number)
        except (TimeoutError, WaxError, aiohttp.ClientError) as error:
            return Sample(at_s=time.monotonic(), problem=str(error) or repr(error))
        return Sample(at_s=time.monotonic(), viewers=tuple(map(_counts, self._here)))

    async def hold(self, number: int) -> None:
        leaving, self._here = self._here[number:], self._here[:number]
        await asyncio.gather(*(viewer.close() for viewer in leaving))
        while (here := len(self._here)) < number:
            some = range(here, min(here + JOINING_AT_ONCE, number))
            self._here += await asyncio.gather(*map(self._join, some))

    async def _cycle(self, number: int) -> None:
        for start in range(0, number, JOINING_AT_ONCE):
            some = range(start, min(start + JOINING_AT_ONCE, number))
            viewers = await asyncio.gather(*(self._join(self._slow + one) for one in some))
            await asyncio.gather(*(viewer.close() for viewer in viewers))

    async def _join(self, index: int) -> Viewer:
        is_slow = index < self._slow
        viewer = self._make(on_socket=partial(put_behind, seed=index) if is_slow else None)
        try:
            async with asyncio.timeout(CONNECT_TIMEOUT_S):
                await viewer.connect()
                # The server decides what gets through a modem.
                for arrived in () if is_slow else viewer.media.arrived.values():
                    await arrived.wait()
        except BaseException as error:
            await viewer.close()
            if isinstance(error, TimeoutError):
                wanted = f"viewer {index + 1} sees or hears nothing in {CONNECT_TIMEOUT_S:g} s"
                raise TimeoutError(wanted) from error
            raise
        return viewer


def _counts(viewer: Viewer) -> ViewerCounts:
    media = viewer.media
    return ViewerCounts(
        video=media.counts("video"), audio=media.counts("audio"), answers=media.answers
    )


async def _serve(viewers: Viewers) -> None:
    try:
        while line := (await asyncio.to_thread(sys.stdin.readline)).split():
            sample = await viewers.answer(line[0], int(line[1]))
            print(sample.model_dump_json(), flush=True)
    finally:
        await viewers.hold(0)


if __name__ == "__main__":
    # A browser waits 30 s for any answer to its checks (RFC 7675); aioice counts each as lost after
    # 0.5 s, and would leave a server that hangs now and then.
    private.install()
    url, how, slow = sys.argv[1:]
    asyncio.run(_serve(Viewers(url, how, int(slow))))
