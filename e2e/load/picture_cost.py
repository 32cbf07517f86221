"""What a picture costs: the server on one core, from capture to the wire, for one viewer."""

from __future__ import annotations

import asyncio
import time
from contextlib import AsyncExitStack
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

from e2e.harness.wait import eventually
from e2e.load.process import pinned, two_cores
from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from wax.client.client import Client

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from e2e.load.servers import MeasuredServer

SIZES: Final = ((640, 480, 1_000_000), (1280, 720, 2_500_000))
CODECS: Final = ("vp8", "h264")
FPS: Final = 30
_WINDOWS: Final = 5
_SETTLE_S: Final = 4.0
_GROW_S: Final = 30.0
_FIRST: Final = {"width": 320, "height": 240, "fps": FPS, "bitrate_bps": 300_000}


@dataclass(frozen=True, slots=True)
class Cost:
    """CPU time of the whole server, in ms for each picture, window by window.

    `unwatched` is without a viewer: the test card is drawn, and nothing encoded. `watched` is with
    one, who receives `fps` pictures a second.
    """

    unwatched: list[float]
    watched: list[float]
    fps: float


async def picture_cost(n: int) -> list[Row]:
    """Measure about `n` pictures of each size and codec, in windows."""
    cores = two_cores()
    if cores is None:
        raise NotRunError("picture-cost needs two cores and a way to pin processes to them (Linux)")
    rows: list[Row] = []
    window_s = max(1.0, n / _WINDOWS / FPS)
    for shape, codec in product(SIZES, CODECS):
        cost = await _cost(shape, codec, window_s, cores)
        rows.append(row_of(*shape[:2], codec, cost, round(window_s * _WINDOWS * cost.fps)))
    return rows


def row_of(width: int, height: int, codec: str, cost: Cost, n: int) -> Row:
    """Tell the median window; what is drawn and not encoded is in the detail."""
    watched, unwatched = summarize(cost.watched), summarize(cost.unwatched)
    return judged(
        f"picture-cost: {width}×{height} {codec}",
        f"CPU for a picture of {width}×{height} by {codec.upper()}, from capture to the wire, of"
        " the whole server on one core",
        "ms",
        {WAX: watched.median},
        n=n,
        spread=watched,
        load=f"one viewer, {cost.fps:.1f} of {FPS} pictures a second, the test card, no sound",
        detail={"unwatched_ms": str(unwatched), "share": watched.median * cost.fps / 1000},
    )


async def _cost(
    shape: tuple[int, int, int], codec: str, window_s: float, cores: tuple[int, int]
) -> Cost:
    width, height, rate_bps = shape
    core, viewers = cores
    size = {"width": width, "height": height, "fps": FPS}
    video = {
        "source": "testcard",
        "codec": codec,
        "encoder": "software",
        # A link is known to carry little until it was tried with something that it does carry.
        "renditions": [size | {"bitrate_bps": rate_bps}, _FIRST],
    }
    async with AsyncExitStack() as leaving:
        leaving.enter_context(pinned(viewers))  # this process, which is the viewer
        server = await leaving.enter_async_context(
            serving(WAX, core, video=video | size, audio={"source": "none"})
        )
        await asyncio.sleep(_SETTLE_S)
        unwatched = [await _window(server, window_s, lambda: 0) for _ in range(_WINDOWS)]
        viewer = await leaving.enter_async_context(Client(server.url))
        frames: Callable[[], int] = lambda: viewer.media.counts("video").frames  # noqa: E731
        await eventually(
            lambda: _gets(server, f"{width}x{height}"),
            "the viewer gets the large pictures",
            within_s=_GROW_S,
        )
        await asyncio.sleep(_SETTLE_S)
        began_s, before = time.monotonic(), frames()
        watched = [await _window(server, window_s, frames) for _ in range(_WINDOWS)]
        fps = (frames() - before) / (time.monotonic() - began_s)
    return Cost(
        unwatched=[cpu_s * 1000 / (window_s * FPS) for cpu_s, _ in unwatched],
        watched=per_picture(watched),
        fps=fps,
    )


def per_picture(windows: Sequence[tuple[float, int]]) -> list[float]:
    """Return ms of CPU for each picture; raises `MeasureError` where none came."""
    if any(count == 0 for _, count in windows):
        raise MeasureError("there was a window without a picture")
    return [cpu_s * 1000 / count for cpu_s, count in windows]


async def _window(
    server: MeasuredServer, seconds: float, frames: Callable[[], int]
) -> tuple[float, int]:
    cpu_s, count = server.meter.cpu_s(), frames()
    await asyncio.sleep(seconds)
    return server.meter.cpu_s() - cpu_s, frames() - count


async def _gets(server: MeasuredServer, size: str) -> bool:
    viewers = (await server.status())["viewers"]
    return any((one["streams"]["rendition"] or "").startswith(size) for one in viewers)
