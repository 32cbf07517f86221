"""From each kind of input to the robot's line, which comes after the gate."""

from __future__ import annotations

import asyncio
import random
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.gallery.views import COMPUTER, PHONE
from e2e.harness.board import Board
from e2e.harness.page_clock import page_clock
from e2e.load.page.driven import browsing, drives
from e2e.load.strokes import HOLD_S, REST_S, Stroke, changes, delays
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged, quantiles, summed
from e2e.stop.record import Record

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.load.page.ways import Way
    from e2e.load.strokes import Change

GOAL_MS: Final = 20.0
ANSWERED: Final = 0.95
"""If more than the remaining presses have no effect, the others' delays mean nothing."""
_SCRIPT: Final = Path(__file__).with_name("input.js").read_text(encoding="utf-8")


async def input_to_gate(way: Way, n: int) -> list[Row]:
    """Press `n` times in a real browser, at random phase against everything periodic.

    The measurement ends after the gate: with the whole frame on the serial line.
    """
    with TemporaryDirectory(prefix="wax-load-") as folder:
        async with Board(Path(folder), base=way.base) as board:
            strokes, told_ms, error_ms = await _made(way, {"robot": board.robot}, n)
            record = Record(board.log_path)
            record.read()
    found = rows(way, strokes, changes(record.frames), error_ms)
    if way.is_touched:
        what = "… of which until the browser tells the page, which no page can shorten"
        key = f"input/{way.key}: told"
        found.append(judged(key, what, "ms", quantiles(told_ms), n=len(told_ms), column="median"))
    return found


def rows(
    way: Way, strokes: Sequence[Stroke], moves: Sequence[Change], clock_error_ms: float
) -> list[Row]:
    """Sum up the presses; raises `MeasureError` if too many had no effect."""
    presses = sum(stroke.down for stroke in strokes)
    presses_ms = delays(strokes, moves, down=True)
    unanswered = presses - len(presses_ms)
    if len(presses_ms) < ANSWERED * presses:
        raise MeasureError(f"{way.what}: of {presses} presses {len(presses_ms)} moved the robot")
    what = f"{way.what} → the whole frame on the serial line, which is behind the gate"
    found = [
        summed(
            f"input/{way.key}",
            what,
            "ms",
            presses_ms,
            GOAL_MS,
            judged="p99",
            unanswered=unanswered,
            clock_error_ms=clock_error_ms,
        )
    ]
    released_ms = delays(strokes, moves, down=False)
    key, what = f"input/{way.key}: release", "… let go → the frame that stops"
    return [*found, summed(key, what, "ms", released_ms, GOAL_MS, judged="p99")]


async def _made(
    way: Way, settings: dict[str, Any], n: int
) -> tuple[list[Stroke], list[float], float]:
    """Drive in this way; return strokes, how long the browser held them, and its clock's error."""
    device = PHONE if way.is_touched else COMPUTER
    async with browsing(settings) as (browser, url):
        viewer = await drives(await browser.new_context(**device.context), url, _SCRIPT)
        hand = await way.reaches(viewer)
        before = await page_clock(viewer.page.evaluate)
        await viewer.page.evaluate("waxInputs.length = 0")
        for _ in range(n):
            await hand.press()
            await asyncio.sleep(random.uniform(*HOLD_S))
            await hand.release()
            await asyncio.sleep(random.uniform(*REST_S))
        after = await page_clock(viewer.page.evaluate)
        noted = await viewer.page.evaluate("waxInputs")
    clock, drift_s = min(before, after), abs(before.ahead_s - after.ahead_s)
    strokes = [
        Stroke(one.down, clock.monotonic_s(one.made_ms) * 1000) for one in way.strokes(noted)
    ]
    error_ms = max(before.error_s, after.error_s, drift_s) * 1000
    return strokes, way.told_after_ms(noted), error_ms
