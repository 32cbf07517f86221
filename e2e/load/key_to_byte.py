"""The time from a key press in the browser to the first moving frame on the serial line."""

from __future__ import annotations

import asyncio
import random
from bisect import bisect_left
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from playwright.async_api import async_playwright

from e2e.harness.board import Board
from e2e.harness.chromium import launch_chromium
from e2e.harness.page_clock import page_clock
from e2e.harness.viewer import Viewer
from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from e2e.stop.record import Record

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from e2e.stop.record import Seen

GOAL_MS: Final = 25.0
_KEY: Final = "ArrowUp"
REST_S: Final = (0.2, 0.4)
HOLD_S: Final = (0.12, 0.3)
_SETTLE_S: Final = 1.0
_KEYS: Final = """
(() => {
  window.waxBenchKeys = [];
  const note = (event) => {
    if (!event.isTrusted || event.repeat) return;
    window.waxBenchKeys.push([event.type, event.code, event.timeStamp]);
  };
  addEventListener("keydown", note, { capture: true });
  addEventListener("keyup", note, { capture: true });
})();
"""
"""Notes each key that goes down or up, with the time of the browser's event."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """A key that went down or up, by the browser's time stamp of the event; CLOCK_MONOTONIC."""

    down: bool
    made_ms: float


@dataclass(frozen=True, slots=True)
class Change:
    """From standing to moving or back, when the frame that says so was whole; CLOCK_MONOTONIC."""

    at_ms: float
    moving: bool


async def key_to_byte(n: int) -> list[Row]:
    """Press `n` times in a real browser, at random phase against all that beats.

    Browser and line are on one clock, to ± `clock_error_ms`. `unanswered` strokes had no effect
    before the next stroke.
    """
    with TemporaryDirectory(prefix="wax-bench-") as folder:
        board = Board(Path(folder))
        await board.start()
        try:
            robot = {"driver": "serial", "serial": {"url": str(board.path)}}
            strokes, clock_error_ms = await strokes_at(robot, n)
            record = Record(board.log_path)
            record.read()
        finally:
            await board.stop()
    moves = changes(record.frames)
    presses_ms, releases_ms = (delays(strokes, moves, down=down) for down in (True, False))
    spread = summarize(presses_ms)
    what = "key press → the whole frame on the serial line"
    return [
        judged("key-to-byte: median", f"{what}, median", "ms", {WAX: spread.median}, n=n),
        judged(
            "key-to-byte: p99",
            f"{what}, p99",
            "ms",
            {WAX: spread.p99},
            GOAL_MS,
            n=n,
            spread=spread,
            detail={
                "release": str(summarize(releases_ms)),
                "unanswered": 2 * n - len(presses_ms) - len(releases_ms),
                "clock_error_ms": clock_error_ms,
            },
        ),
    ]


async def strokes_at(
    robot: Mapping[str, Any],
    n: int,
    environment: Mapping[str, str] | None = None,
    *,
    hold_s: tuple[float, float] = HOLD_S,
    rest_s: tuple[float, float] = REST_S,
) -> tuple[list[Stroke], float]:
    """Drive that robot and type; gives the strokes, and how well their clock is known in ms."""
    async with (
        serving(WAX, environment=environment, robot=robot) as server,
        async_playwright() as playwright,
    ):
        browser = await launch_chromium(playwright)
        viewer = await Viewer.prepare(await browser.new_context(), server.url)
        await viewer.page.add_init_script(_KEYS)
        await viewer.page.goto(server.url)
        await viewer.call_oneself("Bench")
        await viewer.join()
        await viewer.drives()
        await asyncio.sleep(_SETTLE_S)
        before = await page_clock(viewer.page.evaluate)
        for _ in range(n):
            await viewer.page.keyboard.down(_KEY)
            await asyncio.sleep(random.uniform(*hold_s))
            await viewer.page.keyboard.up(_KEY)
            await asyncio.sleep(random.uniform(*rest_s))
        after = await page_clock(viewer.page.evaluate)
        noted = await viewer.page.evaluate("window.waxBenchKeys")
        await browser.close()
    clock, drift_s = min(before, after), abs(before.ahead_s - after.ahead_s)
    strokes = [
        Stroke(kind == "keydown", clock.monotonic_s(made_ms) * 1000)
        for kind, code, made_ms in noted
        if code == _KEY
    ]
    return strokes, max(before.error_s, after.error_s, drift_s) * 1000


def changes(frames: Iterable[Seen]) -> list[Change]:
    """Find when the robot was told to move and when to stand; only frames that were taken count."""
    found: list[Change] = []
    moving = False
    for frame in frames:
        if frame.taken and frame.kind in {"drive", "stop"} and frame.moves is not moving:
            moving = frame.moves
            found.append(Change(at_ms=frame.at_s * 1000, moving=moving))
    return found


def delays(strokes: list[Stroke], moves: list[Change], *, down: bool) -> list[float]:
    """Find how long after each stroke its effect came, in ms."""
    if not moves:
        raise MeasureError("the robot's line stayed silent")
    times_ms = [move.at_ms for move in moves]
    ends_ms = [stroke.made_ms for stroke in strokes[1:]] + [float("inf")]
    found = []
    for stroke, end_ms in zip(strokes, ends_ms, strict=True):
        if stroke.down is not down:
            continue
        index = bisect_left(times_ms, stroke.made_ms)
        if index < len(moves) and times_ms[index] < end_ms and moves[index].moving is down:
            found.append(times_ms[index] - stroke.made_ms)
    return found
