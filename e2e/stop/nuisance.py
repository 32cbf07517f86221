"""Nuisance stops: how often the robot stops for no reason on a bad but sufficient link."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.row import judged
from e2e.stop.operator import RawOperator
from e2e.stop.relay import COMMAND_BYTES, Relay, Weather
from e2e.stop.stage import staged
from wax.config.settings import Settings
from wax.control import gate
from wax.control.gate import Command, TurnView
from wax.control.picture_clock import PictureClock
from wax.control.rules import Rules
from wax.driver.interface import Limits

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from e2e.measure.row import Row
    from e2e.stop.operator import Sent
    from e2e.stop.record import Seen
    from e2e.stop.relay import Packet

BAD: Final = Weather(delay_ms=60, jitter_ms=30, loss=0.02)
GOAL: Final = 1.0
"""Stops in ten minutes."""
TTLS_MS: Final = (100, 125, 150, 175, 200, 250, 300)
_TEN_MINUTES_S: Final = 600.0
_BEAT_S: Final = 0.02
_VIEWER: Final = 1


@dataclass(frozen=True, slots=True)
class Arrival:
    """One command at the server, on one clock."""

    at_s: float
    seq: int
    sent_s: float


async def nuisance(n: int, **settings: Any) -> Row:
    """Drive for `n` seconds over a bad link, and count the stops."""
    relay = Relay(BAD)
    async with staged(**settings) as stage, RawOperator(stage.server, relay=relay) as operator:
        # The link's delay must be known at the turn's start.
        await asyncio.sleep(2.0)
        await operator.join()
        await stage.drive(operator)
        operator.sent_before.clear()
        relay.up.clear()
        since_s = time.monotonic()
        while time.monotonic() < since_s + n:
            await asyncio.sleep(0.5)
            stage.record.read()
            # A longer lapse needs a new press, as a person would give it.
            frames = stage.record.frames
            if frames and not frames[-1].moves:
                await stage.drive(operator)
        until_s = time.monotonic()
        stage.record.read()
        stops = halts(stage.record.between(since_s, until_s))
        one_way_s = operator.clock.one_way_s
        found = arrivals(operator.sent_before, relay.up)
    scale = _TEN_MINUTES_S / (until_s - since_s)
    return judged(
        "nuisance",
        "stops for no reason in 10 min at 2 % loss and 60 ± 30 ms",
        "",
        {"max": stops * scale},
        GOAL,
        n=n,
        column="max",
        detail={
            "stops": stops,
            "stops_in_ten_minutes_by_time_to_live": {
                f"{ttl_ms} ms": round(replayed(found, one_way_s, ttl_ms) * scale, 2)
                for ttl_ms in TTLS_MS
            },
            "one_way_ms": one_way_s * 1000,
            "late_by_this_machine_ms": max(operator.worst_late_s, relay.worst_late_s) * 1000,
        },
    )


def halts(frames: Sequence[Seen]) -> int:
    """Count how often motion turned into standstill."""
    return sum(before.moves and not after.moves for before, after in pairwise(frames))


def arrivals(sent: Iterable[Sent], packets: Iterable[Packet]) -> list[Arrival]:
    """Find the command that each packet carried: the newest sent before it came.

    What was sent between that and the one before went with it, or not at all; either way the
    newer one counts.
    """
    commands = list(sent)
    found: list[Arrival] = []
    index = -1
    for packet in packets:
        if packet.size < COMMAND_BYTES:
            continue
        newest = index
        while newest + 1 < len(commands) and commands[newest + 1].at_s <= packet.came_s:
            newest += 1
        if newest > index:
            index = newest
            if packet.leaves_s is not None:
                one = commands[index]
                found.append(Arrival(packet.leaves_s, one.seq, one.at_s))
    return sorted(found, key=lambda one: one.at_s)


def replayed(found: Sequence[Arrival], one_way_s: float, max_age_ms: float) -> int:
    """Count the stops of the real gate for these arrivals with another time-to-live."""
    if not found:
        return 0
    limits = Limits(linear_mps=1.0, angular_rps=1.0)
    shipped = Settings()
    rules = replace(
        Rules.of(shipped.drive, shipped.robot, limits),
        max_age_s=max_age_ms / 1000,
        max_command_age_s=2.0,
    )
    turn = TurnView(
        number=1,
        operator=_VIEWER,
        present=True,
        one_way_s=one_way_s,
        sees=False,
        picture=PictureClock(),
    )
    state = gate.begin(1, found[0].sent_s)
    stops, moved, neutral = 0, False, True
    now_s, at = found[0].at_s, 0
    while now_s < found[-1].at_s:
        while at < len(found) and found[at].at_s <= now_s:
            one = found[at]
            share = 0.0 if neutral else 1.0
            command = Command(
                one.seq, 1, one.sent_s, share, 0.0, not neutral, "slow", heard_s=one.sent_s
            )
            state, refusal = gate.accept(
                state, _VIEWER, command, turn=turn, now_s=one.at_s, rules=rules
            )
            neutral = neutral and refusal is not None
            at += 1
        state, setpoint = gate.decide(state, turn, None, now_s, rules)
        moves = not setpoint.twist.is_zero
        stops += moved and not moves
        # An operator who must release does so: the next command that arrives is neutral.
        neutral = neutral or state.command is None
        moved = moves
        now_s += _BEAT_S
    return stops
