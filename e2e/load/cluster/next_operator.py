"""Pages that wait in a room come to the robot's own server for their turn, and go back after it."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.load.cluster.page import browsers, longest_gap_ms, now_ms, pictures_ms, unix_ms
from e2e.load.cluster.stage import staged
from e2e.measure.row import Row, counted, timed
from wax.client.operator import Operator

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.load.cluster.page import Page, Place

TURN_S: Final = 8.0
"""Whoever has driven waits again; where four do, for 24 s: longer than the 20 s above which a page
goes back to its room, which it leaves again for the last 11 s."""
_PAGES: Final = 3
_SECOND_MS: Final = 1000.0
_AFTER_MS: Final = 500.0


@dataclass(frozen=True, slots=True)
class Turn:
    number: int
    name: str
    begins_ms: float


@dataclass(frozen=True, slots=True)
class Move:
    """From a room to a turn and back: since when the page waited, and was back; Unix ms."""

    waits_ms: float
    turn: Turn
    back_ms: float


class Turns:
    """Whose turn begins when, as everybody at the robot's own server is told."""

    def __init__(self) -> None:
        self.begun: dict[int, Turn] = {}
        self.ahead_ms = 0.0

    def learn(self, message: dict[str, Any]) -> None:
        """Take any message of the state channel."""
        if message["type"] != "room":
            return
        turn, viewers = message["turn"], message["viewers"]
        name = next((one["name"] for one in viewers if one["id"] == turn["operator"]), None)
        if name is not None and turn["number"] not in self.begun:
            begins_s = (turn["ends_server_ms"] - self.ahead_ms) / 1000 - TURN_S
            self.begun[turn["number"]] = Turn(turn["number"], name, unix_ms(begins_s))

    async def of(self, name: str, after_ms: float) -> Turn:
        """Wait for the next turn of somebody."""

        async def begun() -> list[Turn]:
            mine = [one for one in self.begun.values() if one.name == name]
            return [one for one in mine if one.begins_ms > after_ms]

        within_s = (_PAGES + 2) * TURN_S
        return (await eventually(begun, f"{name} has a turn", within_s=within_s))[0]


async def next_operator(n: int) -> list[Row]:
    """Have pages take `n` turns, by turns with somebody who stays at the robot's own server."""
    turns = Turns()
    async with (
        staged(turns={"turn_s": TURN_S}, server={"max_viewers": 1}) as stage,
        browsers() as chromium,
    ):
        async with Operator(stage.server.url, on_message=turns.learn) as first:
            pages = [await chromium.open(stage.server.url) for _ in range(_PAGES)]
            for number, page in enumerate(pages):
                await page.viewer.call_oneself(f"Page {number}")
            turns.ahead_ms = first.clock.ahead_ms
            await first.join()
            left = iter(range(n))
            moves = await asyncio.gather(
                *(_move(page, f"Page {number}", turns, left) for number, page in enumerate(pages))
            )
        found = [
            (move, await page.places(), pictures_ms(await page.readings()))
            for page, moved in zip(pages, moves, strict=True)
            for move in moved
        ]
    leads_ms = [_lead_ms(move, places) for move, places, _ in found]
    to_ms = [
        longest_gap_ms(shown, move.waits_ms, move.turn.begins_ms + _AFTER_MS)
        for move, _, shown in found
    ]
    home_ms = [
        longest_gap_ms(shown, move.turn.begins_ms + TURN_S * 1000, move.back_ms)
        for move, _, shown in found
    ]
    return [
        counted(
            "next-operator: late",
            "turns that began before the picture of the robot's own server was there",
            sum(lead is None or lead < 0 for lead in leads_ms),
            len(found),
            least_lead_ms=min((lead for lead in leads_ms if lead is not None), default=None),
        ),
        counted(
            "next-operator: seconds",
            "… whole seconds without a new picture on the way there",
            sum(int(gap // _SECOND_MS) for gap in to_ms),
            len(found),
        ),
        timed("next-operator: there", "… longest time without one", to_ms, _SECOND_MS),
        timed("next-operator: back", "… and on the way back to the room", home_ms, _SECOND_MS),
    ]


async def _move(page: Page, name: str, turns: Turns, left: Any) -> list[Move]:
    """Take turns until as many have been taken together as are wanted."""
    moves = []
    await page.viewer.join()
    for _ in left:
        waits_ms = now_ms()
        turn = await turns.of(name, waits_ms)
        await asyncio.sleep((turn.begins_ms - now_ms()) / 1000 + TURN_S)
        await page.shows("room")
        back_ms = now_ms()
        await asyncio.sleep(_AFTER_MS / 1000)
        moves.append(Move(waits_ms, turn, back_ms))
    return moves


def _lead_ms(move: Move, places: Sequence[tuple[float, Place]]) -> float | None:
    """Return how long before the turn the server's picture came; None if it never did."""
    came_ms = [at for at, place in places if place == "server" and at >= move.waits_ms]
    return move.turn.begins_ms - came_ms[0] if came_ms else None
