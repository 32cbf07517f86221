"""From a key that goes down in the browser to the first frame on the serial line that moves."""

from __future__ import annotations

import random
import time
from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.bench.board import Board
from e2e.bench.browser import KEYS_JS, chromium, fresh_page, page_clock
from e2e.bench.errors import BenchError
from e2e.bench.motion import Change, changes
from e2e.bench.servers import TEST_CARD, Server
from e2e.bench.spread import Spread, spread

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from e2e.bench.browser import PageClock
    from e2e.bench.plan import Plan
    from e2e.bench.servers import Side

DIALECT = "frames"
KEY = "ArrowUp"
REST_S = (0.2, 0.4)
HOLD_S = (0.12, 0.3)
SETTLE_S = 1.0


@dataclass(frozen=True, slots=True)
class Stroke:
    """A key that went down or up, on CLOCK_MONOTONIC.

    `made_ms` is the browser's time stamp of the event, `handled_ms` when the page saw it.
    """

    down: bool
    made_ms: float
    handled_ms: float


@dataclass(frozen=True, slots=True)
class KeyToByte:
    """`press_ms` ends with the frame that lets the robot move, `release_ms` with that of its stop.

    Both begin with the browser's own time stamp of the key event; `handled_ms` begins later, at
    the page's listener. Browser and line are on one clock, to ± `clock_error_ms`. `unanswered`
    strokes had no effect before the next stroke.
    """

    dialect: str
    press_ms: Spread
    release_ms: Spread
    handled_ms: Spread
    unanswered: int
    clock_error_ms: float


def measure(side: Side, plan: Plan) -> KeyToByte:
    """Type in a real browser; `side` is ours, since a stock aiortc server has no robot."""
    with Board() as board:
        with (
            Server(side, settings=_settings(board.url)) as server,
            chromium() as browser,
            fresh_page(browser, KEYS_JS) as page,
        ):
            page.goto(server.url)
            _take_the_wheel(page)
            clock_before = page_clock(page)
            _type(page, plan.presses)
            clock_after = page_clock(page)
            strokes = _strokes(page, min((clock_before, clock_after), key=lambda c: c.error_ms))
        moves = changes(board.finish())
    drift_ms = abs(clock_before.offset_ms - clock_after.offset_ms)
    press_ms = delays(strokes, moves, down=True)
    release_ms = delays(strokes, moves, down=False)
    return KeyToByte(
        dialect=DIALECT,
        press_ms=spread([delay_ms for delay_ms, _ in press_ms]),
        release_ms=spread([delay_ms for delay_ms, _ in release_ms]),
        handled_ms=spread([delay_ms for _, delay_ms in press_ms]),
        unanswered=2 * plan.presses - len(press_ms) - len(release_ms),
        clock_error_ms=max(clock_before.error_ms, clock_after.error_ms, drift_ms),
    )


def _settings(url: str) -> str:
    robot = f'[robot]\ndriver = "serial"\n[robot.serial]\nurl = "{url}"\ndialect = "{DIALECT}"\n'
    return TEST_CARD + robot


def _take_the_wheel(page: Page) -> None:
    name = page.get_by_role("textbox", name="Your name", exact=True)
    name.fill("Bench")
    name.press("Enter")
    page.get_by_role("button", name="Join the queue", exact=True).click()
    page.get_by_text("You are driving").first.wait_for(state="visible")
    time.sleep(SETTLE_S)


def _type(page: Page, presses: int) -> None:
    """Press at random phase against the server's loop and the page's own ticks."""
    for _ in range(presses):
        page.keyboard.down(KEY)
        time.sleep(random.uniform(*HOLD_S))
        page.keyboard.up(KEY)
        time.sleep(random.uniform(*REST_S))


def _strokes(page: Page, clock: PageClock) -> list[Stroke]:
    noted = page.evaluate("window.waxBenchKeys")
    return [
        Stroke(
            down=kind == "keydown",
            made_ms=made_ms + clock.offset_ms,
            handled_ms=handled_ms + clock.offset_ms,
        )
        for kind, code, made_ms, handled_ms in noted
        if code == KEY
    ]


def delays(strokes: list[Stroke], moves: list[Change], *, down: bool) -> list[tuple[float, float]]:
    """Find each stroke's effect; ms since the event was made and since it was handled."""
    if not moves:
        raise BenchError("the robot's line stayed silent")
    times_ms = [move.at_ms for move in moves]
    ends_ms = [stroke.made_ms for stroke in strokes[1:]] + [float("inf")]
    found = []
    for stroke, end_ms in zip(strokes, ends_ms, strict=True):
        if stroke.down is not down:
            continue
        index = bisect_left(times_ms, stroke.made_ms)
        if index < len(moves) and times_ms[index] < end_ms and moves[index].moving is down:
            found.append((times_ms[index] - stroke.made_ms, times_ms[index] - stroke.handled_ms))
    return found
