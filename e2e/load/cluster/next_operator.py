"""Pages that wait in a room come to the robot's own server for their turn, and then return."""

from __future__ import annotations

import asyncio
import statistics
from typing import TYPE_CHECKING, Final

from e2e.load.cluster.page import longest_gap_ms, now_ms, pages
from e2e.load.cluster.stage import staged
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, middle, timed
from wax.client.operator import Operator

if TYPE_CHECKING:
    from collections.abc import Iterator

    from e2e.load.cluster.page import Page

TURN_S: Final = 8.0
"""After driving, a page waits again; with four of them for 24 s. Above 20 s a page returns to its
room, which it leaves again for the last 11 s."""
_PAGES: Final = 3
_DRIVES: Final = "You are driving"
_GAP_MS: Final = 1000.0
_AFTER_MS: Final = 500.0
_LATER_MS: Final = 15.0
_SETTLE_S: Final = 12.0
"""By then both pages hold the picture back for the sound, having adapted in steps."""
_CARDS: Final = 150


async def next_operator(n: int) -> list[Row]:
    """Let pages take `n` turns, alternating with somebody who stays at the robot's own server."""
    async with (
        staged(turns={"turn_s": TURN_S}) as stage,
        pages() as open_page,
        Operator(stage.server.url) as first,
    ):
        opened = [await open_page(stage.server.url) for _ in range(_PAGES)]
        await first.join()
        left = iter(range(n))
        found = await asyncio.gather(*(_moves(page, left) for page in opened))
    moves = [move for moved in found for move in moved]
    late = sum(is_late for is_late, _ in moves)
    what = "room → own turn → room: longest time without a new picture; none after a turn began"
    return [timed("next-operator", what, [gap_ms for _, gap_ms in moves], _GAP_MS, wrong=late)]


async def _moves(page: Page, left: Iterator[int]) -> list[tuple[bool, float]]:
    """Take turns until all pages together have taken enough.

    Return for each whether the server's picture came after the turn began, and the longest time
    without a new picture on the way there or back.
    """
    moves = []
    await page.viewer.join()
    for _ in left:
        waits_ms = now_ms()
        waited_ms = await page.says(_DRIVES, waits_ms, (_PAGES + 2) * TURN_S, "turn")
        if waited_ms is None:
            raise MeasureError("a page that waits got no turn")
        begins_ms = waits_ms + waited_ms
        ends_ms = begins_ms + TURN_S * 1000
        await asyncio.sleep((ends_ms - now_ms()) / 1000)
        await page.shows("room")
        back_ms = now_ms()
        await asyncio.sleep(_AFTER_MS / 1000)
        shown_ms, places = await page.pictures_ms(), await page.places()
        came_ms = [at for at, place in places if place == "server" and at >= waits_ms]
        there_ms = longest_gap_ms(shown_ms, waits_ms, begins_ms + _AFTER_MS)
        home_ms = longest_gap_ms(shown_ms, ends_ms, back_ms)
        moves.append((not came_ms or came_ms[0] > begins_ms, max(there_ms, home_ms)))
    return moves


async def room_delay(n: int) -> list[Row]:
    """Read `n` cards off two pages at once, one in a room and one at the robot's own server."""
    async with staged(server={"max_viewers": 1}) as stage, pages() as open_page:
        here = await open_page(stage.server.url)
        await here.shows("server")
        there = await open_page(stage.server.url)
        await there.shows("room")
        await asyncio.sleep(_SETTLE_S)
        later_ms = []
        for _ in range(n):
            cards = await asyncio.gather(*(one.viewer.cards(_CARDS) for one in (there, here)))
            room, server = ([one.age_ms for one in some if one.valid] for some in cards)
            later_ms.append(statistics.median(room) - statistics.median(server))
    what = "a picture in a room, p50 when shown, older than at the robot's own server by"
    return [middle("room: later", what, "ms", later_ms, _LATER_MS, n=n)]
