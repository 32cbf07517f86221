"""What grows while somebody drives and ten others come and go: memory, delays, and leaks."""

from __future__ import annotations

import asyncio
import math
import statistics
import time
from collections import Counter
from dataclasses import dataclass, field
from itertools import cycle
from typing import TYPE_CHECKING, Any, Final

from e2e.load.crowd.crowd import gathered
from e2e.load.memory import FLAT_MIB, handles, is_empty
from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, counted, judged
from wax.client import Client, Operator
from wax.control.gate import LAPSE_S
from wax.sentence import read

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from e2e.load.crowd.crowd import Crowd
    from e2e.load.servers import MeasuredServer
    from wax.client.sdp import Kind

_PRESENT: Final = (10, 4, 8, 0, 6, 2, 9, 1, 10, 5, 7, 3)
"""How many observers are present: each number for five seconds, repeated every minute."""
_EVERY_S: Final = 5.0
_SAMPLE_S: Final = 1.0
_GROWN_MS: Final = 5.0
"""Two medians over minutes differ by less, even on a machine that does other work."""
_PRESS_S: Final = 0.3
_PATIENCE_S: Final = 2 * LAPSE_S
"""A person presses again once the robot has stood this long, and no longer resumes by itself."""
_SEES_S: Final = 15.0
_KINDS: Final[tuple[Kind, ...]] = ("audio", "video")


@dataclass(frozen=True, slots=True)
class Sample:
    """One sample: `at` is the share of the soak that is over; ages are None until known."""

    at: float
    rss_mib: float
    sound_ms: float | None
    picture_ms: float | None
    trip_ms: float | None


@dataclass(slots=True)
class Soaked:
    """The result; `left` counts threads, descriptors and tasks beyond those before."""

    lasted_s: float
    samples: list[Sample] = field(default_factory=list)
    stops: list[str] = field(default_factory=list)
    joins: int = 0
    left: int = 0


class Hand:
    """Turns on the spot, where no wall stops the robot with a reason; counts stops.

    The robot follows with a delay. So only a stop after motion counts, while the control is held,
    and the hand presses again only when the robot can no longer resume by itself.
    """

    def __init__(self, operator: Operator, stops: list[str]) -> None:
        self.operator, self._stops = operator, stops
        self._moves, self._has_moved = False, True
        self._since_s = -math.inf
        self._reason, self._refused = "", Counter[str]()

    def told(self, status: dict[str, Any], now_s: float) -> None:
        """Handle the server's `drive_status`."""
        was, self._moves = self._moves, status["moving"]
        reason = status["reason"]
        self._reason = "no reason" if reason is None else str(read(reason))
        if self._moves:
            self._has_moved = True
        elif was and self.operator.held:
            self._since_s = now_s
            self._stops.append(self._reason)

    async def keep_on(self, now_s: float, counts: Mapping[str, float]) -> None:
        """Press again when a person would; a press that moved nothing counts as a stop.

        `counts` are the server's; those of refused commands show why a press moved nothing.
        """
        if self._moves or now_s - self._since_s < _PATIENCE_S:
            return
        refused = Counter({what: int(n) for what, n in counts.items() if ".refused." in what})
        if not self._has_moved:
            met = dict(refused - self._refused)
            self._stops.append(f"moves nothing when pressed: {self._reason} {met}")
        self._refused = refused
        self.operator.let_go()
        await asyncio.sleep(_PRESS_S)
        self.operator.steer(0.0, 1.0)
        self._has_moved, self._since_s = False, now_s


async def soak(seconds: float) -> Soaked:
    """Serve for `seconds`; raises `MeasureError` if somebody drops out."""
    found = Soaked(lasted_s=seconds)
    # With the default `grace_s`, an operator whose machine hangs for a moment keeps the turn.
    async with (
        serving(WAX, turns={"turn_s": 86_400.0}) as server,
        gathered(server.offering, yields=False) as crowd,
    ):
        # What is allocated once, for the first of each kind, is no leak.
        await _serve_all(server, crowd, Soaked(lasted_s=2 * _EVERY_S))
        await is_empty(server)
        before = await handles(server)
        await _serve_all(server, crowd, found)
        await is_empty(server)
        found.left = await handles(server) - before
    return found


async def _serve_all(server: MeasuredServer, crowd: Crowd, found: Soaked) -> None:
    def told(message: dict[str, Any]) -> None:
        if message["type"] == "drive_status":
            hand.told(message, time.monotonic())

    operator = Operator(server.url, sees=True, on_message=told)
    hand = Hand(operator, found.stops)
    async with Client(server.url) as listener, operator:
        # Nobody can drive without a picture; the first one waits for the listener's keyframe.
        async with asyncio.timeout(_SEES_S):
            await operator.media.arrived["video"].wait()
        await operator.join()
        ends_s = time.monotonic() + found.lasted_s
        coming = asyncio.create_task(_come_and_go(crowd, found, ends_s))
        try:
            await _watch(server, listener, hand, found, ends_s)
        finally:
            await coming
        operator.let_go()


async def _come_and_go(crowd: Crowd, found: Soaked, ends_s: float) -> None:
    present = 0
    for number in cycle(_PRESENT):
        if time.monotonic() >= ends_s:
            break
        due_s = time.monotonic() + _EVERY_S
        await crowd.hold(number)
        found.joins += max(0, number - present)
        present = number
        await asyncio.sleep(max(0.0, due_s - time.monotonic()))
    await crowd.hold(0)


async def _watch(
    server: MeasuredServer,
    listener: Client,
    hand: Hand,
    found: Soaked,
    ends_s: float,
) -> None:
    operator = hand.operator
    began_s = ends_s - found.lasted_s
    while (now_s := time.monotonic()) < ends_s:
        there = {"the listener": listener.is_open, "the operator": operator.is_open}
        there["the operator's turn"] = operator.has_turn
        if gone := [who for who, is_there in there.items() if not is_there]:
            raise MeasureError(f"after {now_s - began_s:.0f} s {' and '.join(gone)} is gone")
        status = await server.status()
        trips = {one["id"]: one.get("round_trip_ms") for one in status["viewers"]}
        sound_ms, picture_ms = map(listener.age_ms, _KINDS)
        found.samples.append(
            Sample(
                at=(now_s - began_s) / found.lasted_s,
                rss_mib=server.meter.rss_mib(),
                sound_ms=sound_ms,
                picture_ms=picture_ms,
                trip_ms=trips.get(operator.viewer),
            )
        )
        await hand.keep_on(time.monotonic(), status["counters"])
        await asyncio.sleep(_SAMPLE_S)


def rows(found: Soaked) -> list[Row]:
    """Compare the last sixth with the third one: of half an hour, minutes 25–30 with 10–15."""

    def grown(value: Callable[[Sample], float | None], middle: Callable[..., float]) -> float:
        before, after = (
            [v for one in found.samples if begin <= one.at < end if (v := value(one)) is not None]
            for begin, end in ((1 / 3, 1 / 2), (5 / 6, 1.0))
        )
        if not before or not after:
            raise MeasureError("nothing was measured at the begin or the end")
        return middle(after) - middle(before)

    median = statistics.median
    later_ms = {
        "sound": grown(lambda one: one.sound_ms, median),
        "picture": grown(lambda one: one.picture_ms, median),
        "the operator's round trip": grown(lambda one: one.trip_ms, median),
    }
    samples, seconds = len(found.samples), round(found.lasted_s)
    memory = {"max": grown(lambda one: one.rss_mib, statistics.mean)}
    delay = {"max": max(later_ms.values())}
    what = f"memory at the end of {found.lasted_s / 60:g} min of coming and going, more by"
    stops = "… stops without a reason while the operator drives"
    left = "… threads, descriptors and tasks left by those who came"
    return [
        judged("soak: memory", what, "MiB", memory, FLAT_MIB, n=samples, column="max"),
        judged(
            "soak: delay", "… sound, picture or the operator's round trip, later by", "ms", delay,
            _GROWN_MS, n=samples, column="max", detail=later_ms,
        ),
        counted("soak: left", left, found.left, found.joins),
        counted("soak: stops", stops, len(found.stops), seconds, why=found.stops[:10]),
    ]  # fmt: skip


async def soaked(n: int) -> list[Row]:
    return rows(await soak(float(n)))
