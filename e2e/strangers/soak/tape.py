"""Whether picture and sound stay in step on the tape: the test card, recorded and played back."""

from __future__ import annotations

import asyncio
import math
import statistics
import time
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, counted, timed
from wax.capture.testcard import STAMP_MODULUS, read_stamp
from wax.client import Operator
from wax.clock import SystemClock
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from collections.abc import Iterator

_IN_STEP_MS: Final = 10.0
_SECOND_MS: Final = 1000.0
_NEAR_MS: Final = 500.0
_EDGE_MS: Final = 150.0
"""A burst at a part's begin or end may be cut."""
_LOUD: Final = 0.2
"""Half of a burst's amplitude, four times that of what sounds between."""
_PRESS_S: Final = 0.3
_LOOK_S: Final = 5.0


async def tape_in_step(seconds: int) -> list[Row]:
    """Record the card for so long while somebody drives, play it all, and compare."""
    with TemporaryDirectory(prefix="wax-tape-") as folder:
        await _record(Path(folder), seconds)
        parts = [part.media for part in Shelf(Path(folder)).parts() if part.media is not None]
        judged = await asyncio.gather(*(asyncio.to_thread(skews_ms, part) for part in parts))
    skews = [skew for part in judged for skew in part]
    found = [abs(skew) for skew in skews if skew is not None]
    beyond = [
        f"part {number}, second {second}: {skew}"
        for number, part in enumerate(judged)
        for second, skew in enumerate(part)
        if skew is None or abs(skew) > _IN_STEP_MS
    ]
    return [
        timed("tape: skew", "picture and sound on the tape apart", found, _IN_STEP_MS),
        counted(
            "tape: lost",
            "… seconds of which no burst, or no picture beside it, is there",
            sum(skew is None for skew in skews),
            len(skews),
            parts=len(parts),
            beyond=beyond,
        ),
    ]


async def _record(folder: Path, seconds: int) -> None:
    tape = {"enabled": True, "folder": str(folder), "min_free_gb": 0.0}
    async with (
        serving(WAX, turns={"turn_s": 86_400.0}, recording=tape) as server,
        Operator(server.url, sees=True) as operator,
    ):
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_PRESS_S)
        operator.steer(0.0, 1.0)
        ends_s = time.monotonic() + seconds
        while (left_s := ends_s - time.monotonic()) > 0:
            await asyncio.sleep(min(left_s, _LOOK_S))
            told = (await server.status())["tape"]
            if told["problem"] is not None or told["left_out"]:
                raise MeasureError(f"the tape is not as it was to be: {told}")
        await server.stop()


def skews_ms(path: Path) -> list[float | None]:
    """Return for each whole second of a part how much later its burst is than its picture, ms.

    None where either is missing. The card's stamp says when a picture was captured, a burst begins
    with the second; both are compared with where they stand on the tape.
    """
    offsets = [(at_ms, at_ms - captured_ms) for at_ms, captured_ms in _pictures_ms(path)]
    if len(offsets) < 2:
        raise MeasureError(f"{path.name} has no pictures of the card")
    bursts = list(_bursts_ms(path))
    skews: list[float | None] = []
    begin_ms, end_ms = offsets[0][0] + _EDGE_MS, offsets[-1][0] - _EDGE_MS
    offset_ms = statistics.median(offset for _, offset in offsets)
    second = math.ceil((begin_ms - offset_ms) / _SECOND_MS)
    while (due_ms := second * _SECOND_MS + offset_ms) <= end_ms:
        beside = [offset for at_ms, offset in offsets if abs(at_ms - due_ms) <= _NEAR_MS]
        near = [at_ms for at_ms in bursts if abs(at_ms - due_ms) <= _NEAR_MS]
        if beside and near:
            expected_ms = due_ms - offset_ms + statistics.median(beside)
            skews.append(min((at_ms - expected_ms for at_ms in near), key=abs))
        else:
            skews.append(None)
        second += 1
    return skews


def _pictures_ms(path: Path) -> Iterator[tuple[float, int]]:
    """Yield where each picture of the card stands, and when it was captured (Unix)."""
    now_ms = SystemClock().wall_ms()
    with av.open(path) as file:
        for frame in file.decode(video=0):
            luma = frame.to_ndarray(format="gray").astype(np.uint8, copy=False)
            stamp_ms = read_stamp(luma)
            if stamp_ms is not None and frame.time is not None:
                wraps = round((now_ms - stamp_ms) / STAMP_MODULUS)
                yield frame.time * 1000, stamp_ms + wraps * STAMP_MODULUS


def _bursts_ms(path: Path) -> Iterator[float]:
    """Yield where each burst begins."""
    mono = av.AudioResampler(format="flt", layout="mono", rate=48_000)
    with av.open(path) as file:
        loud: list[float] = []
        for frame in file.decode(audio=0):
            for part in mono.resample(frame):
                begin_ms = (part.time or 0.0) * 1000
                is_loud = np.abs(part.to_ndarray().ravel()) > _LOUD
                loud += [begin_ms + at / 48 for at in np.flatnonzero(is_loud)]
    yield from loud[:1]
    yield from (after for before, after in pairwise(loud) if after - before > _NEAR_MS)
