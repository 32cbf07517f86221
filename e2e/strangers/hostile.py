"""Somebody drives, somebody watches and presses Stop, and meanwhile strangers attack."""

from __future__ import annotations

import asyncio
import json
import os
import random
import time
import tomllib
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import cycle, islice, pairwise
from typing import TYPE_CHECKING, Any, Final, Self

import aiohttp

from e2e.harness import toml
from e2e.load.process import ProcessMeter
from e2e.measure.errors import MeasureError
from e2e.measure.row import summed
from e2e.measure.suite import ROOT
from e2e.measure.summary import summarize
from e2e.stop.operator import RawOperator
from e2e.stop.stage import STOPS_AT_EACH_TRIAL, Load, staged
from e2e.strangers.attacks import ATTACKS
from e2e.strangers.command_times import CommandTimes
from e2e.strangers.intruder import ask
from e2e.strangers.strangers import address, strangers
from wax.errors import SignallingError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from e2e.measure.row import Row
    from e2e.stop.stage import Stage
    from e2e.strangers.strangers import Strangers

MORE_MS: Final = 10.0
FPS_SHARE: Final = 0.95
STOP_MS: Final = 100.0
MORE_MIB: Final = 20.0
NORMAL_S: Final = 1.0
WAYS: Final = ("HTTP", "channel")
_PING_S: Final = 0.1
_PATIENCE_S: Final = 15.0
_LOOK_S: Final = 0.1
_SETTLE_S: Final = 2.0
_TRIAL_S: Final = 1.5
NEWCOMER: Final = address(240)
_NEWCOMER_S: Final = 0.25
_SERVED_S: Final = 3.0
_SILENT_S: Final = 0.1
"""Commands are due each 20 ms, and after 150 the robot stops."""

AS_SHIPPED: Final = Load(
    "640×480 at 30 fps, sound",
    {"video": {"source": "testcard"}, "audio": {"source": "testcard"}},
    0,
)


def public_robot() -> tuple[Mapping[str, Any], Load]:
    """Return `config/public-robot.toml` with the card for a camera, and what it then serves."""
    tree = tomllib.loads((ROOT / "config/public-robot.toml").read_text(encoding="utf-8"))
    # Its robot is the stage's board; whoever joins here drives until the end, and at once.
    del tree["robot"]["driver"], tree["robot"]["serial"]["url"]
    tree["turns"] = {"max_waiting_per_address": tree["turns"]["max_waiting_per_address"]}
    media = {"video": tree.pop("video") | {"source": "testcard"}, "audio": tree.pop("audio")}
    return tree, Load("config/public-robot.toml", media, 0)


@dataclass(slots=True)
class Window:
    """What was seen while it lasted; None among the times is what never came."""

    since_s: float
    until_s: float = 0.0
    fps: float = 0.0
    beat_ms: float | None = None
    round_trips_ms: Sequence[float | None] = ()
    commands_ms: Sequence[float | None] = ()
    stands: int = 0
    unserved: int = 0
    """Newcomers who were not answered."""
    own_late_ms: float = 0.0
    """How late the operator's own timer was, which is not the server's fault."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One attack: before it, during it, and what was left of it."""

    quiet: Window
    during: Window
    stops_ms: Mapping[str, Sequence[float | None]]
    normal_s: float | None
    before_mib: float
    peak_mib: float
    after_mib: float
    account: Mapping[str, Any]


@dataclass(slots=True)
class _RoundTrips:
    """Pings of one operator, ten a second, and when they were answered."""

    operator: RawOperator
    sent_s: dict[int, float] = field(default_factory=dict)
    came_s: dict[int, float] = field(default_factory=dict)

    async def run(self) -> None:
        self.operator.drive.on("message", self._heard)
        while self.operator.drive.readyState == "open":
            self.sent_s[self.operator.ping()] = time.monotonic()
            await asyncio.sleep(_PING_S)

    def between(self, since_s: float, until_s: float) -> list[float | None]:
        """Return how long each took that was sent then, ms; None where no answer has come."""
        return [
            (self.came_s[number] - at_s) * 1000 if number in self.came_s else None
            for number, at_s in self.sent_s.items()
            if since_s <= at_s <= until_s
        ]

    async def normal_after(self, at_s: float, within_ms: float) -> float | None:
        """Return after how many s a ping sent since then was answered as quickly as this."""
        while time.monotonic() - at_s < 2 * _PATIENCE_S:
            for number, sent_s in self.sent_s.items():
                came_s = self.came_s.get(number)
                if sent_s >= at_s and came_s is not None and (came_s - sent_s) * 1000 <= within_ms:
                    return came_s - at_s
            await asyncio.sleep(_LOOK_S)
        return None

    def _heard(self, data: str) -> None:
        kind, number, *_ = json.loads(data)
        if kind == "pong":
            self.came_s[number] = time.monotonic()


class Watch:
    """Steers, pings, presses Stop and looks at the robot; as an async context manager."""

    def __init__(self, stage: Stage, operator: RawOperator, observer: RawOperator) -> None:
        self.stage = stage
        self.operator = operator
        self.observer = observer
        self.trips = _RoundTrips(operator)
        self.peak_mib = 0.0
        self._times = CommandTimes(stage, operator)
        self._unserved_s: list[float] = []
        self._meter = ProcessMeter(stage.server.pid)
        self._tasks: list[asyncio.Task[None]] = []
        self._steering: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        works = (self.trips.run(), self._remember(), self._newcomers())
        self._tasks = [asyncio.create_task(work) for work in works]
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._hold_still()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def mib(self) -> float:
        """Return the server's memory, and take the most from now on."""
        self.peak_mib = self._meter.rss_mib()
        return self.peak_mib

    async def steer(self) -> None:
        """Drive until `stops` or the end, now faster and now slower; raises `MeasureError`."""
        await self.stage.drive(self.operator)
        self._steering = asyncio.create_task(self._times.run())

    async def window(self, seconds: float) -> Window:
        """Look for so long at who steers; `fill` adds what is known only later."""
        made, frames = Window(time.monotonic()), self._frames()
        self.operator.worst_late_s = 0.0
        await asyncio.sleep(seconds)
        made.until_s = time.monotonic()
        made.own_late_ms = self.operator.worst_late_s * 1000
        made.fps = (self._frames() - frames) / (made.until_s - made.since_s)
        with suppress(TimeoutError, aiohttp.ClientError, AssertionError):
            async with asyncio.timeout(_PATIENCE_S):
                counters = (await self.stage.server.status())["counters"]
                made.beat_ms = counters["control.latest_ms"]
        return made

    def fill(self, window: Window) -> None:
        """Add the times, for which late answers have come by now."""
        window.round_trips_ms = self.trips.between(window.since_s, window.until_s)
        window.commands_ms = self._times.between(window.since_s, window.until_s)
        window.stands = self.stands(window.since_s, window.until_s)
        unserved = (window.since_s <= at_s <= window.until_s for at_s in self._unserved_s)
        window.unserved = sum(unserved)

    def stands(self, since_s: float, until_s: float) -> int:
        """Count how often the robot stopped: it was told to, or by its own watchdog.

        What the operator's own silence explains does not count: their process shares this machine.
        """
        record = self.stage.record
        record.read()
        frames = record.between(since_s, until_s)
        stopped_s = [after.at_s for before, after in pairwise(frames) if before.moves > after.moves]
        stopped_s += [at_s for at_s in record.expiries_s if since_s < at_s <= until_s]
        sent_s = [one.at_s for one in self.operator.sent_before]
        silences = [(a, b) for a, b in pairwise(sent_s) if b - a > _SILENT_S]
        return sum(not any(a < at_s < b + _SILENT_S for a, b in silences) for at_s in stopped_s)

    async def stops(self, number: int, until_s: float) -> dict[str, list[float | None]]:
        """Press Stop so often, each way in turn; return the ms until the robot was told.

        Where it stands already, until the operator's page was told.
        """
        await self._hold_still()
        found: dict[str, list[float | None]] = {way: [] for way in WAYS}
        for way in islice(cycle(WAYS), number):
            if time.monotonic() < until_s:
                with suppress(MeasureError):
                    await self.stage.drive(self.operator)
                found[way].append(await self._stop(way))
        return found

    async def settled_mib(self, most_mib: float) -> float:
        """Wait until memory is back, as long as people would; return what it is."""
        for _ in range(int(_PATIENCE_S / _LOOK_S)):
            if (mib := self._meter.rss_mib()) <= most_mib:
                break
            await asyncio.sleep(_LOOK_S)
        return mib

    def socket_of(self, viewer: RawOperator) -> tuple[Any, tuple[str, int]]:
        """Return the socket that a viewer's peer sends by, and where to."""
        association: Any = viewer.peer.sctp
        pair = association.transport.transport._connection._nominated[1]
        return pair.protocol.transport, pair.remote_addr

    async def _stop(self, way: str) -> float | None:
        operator, record = self.operator, self.stage.record
        since_s = time.monotonic()
        record.read()
        moved = record.moved_at(since_s)
        pressing = asyncio.create_task(self._press(way))
        is_told = await operator.until(lambda: operator.stopped is not None, _PATIENCE_S)
        told_s = time.monotonic()
        await pressing
        stop = operator.stopped
        if not is_told or stop is None:
            return None
        operator.let_go()
        await asyncio.sleep(_LOOK_S)  # a board's log is behind by a frame
        for _ in range(int(_PATIENCE_S)):  # it may be refused while it is too old
            operator.release(stop)
            if await operator.until(lambda: operator.stopped is None, 1.0):
                break
        record.read()
        if not moved:
            return (told_s - since_s) * 1000
        return record.stopping(since_s, told_s + _LOOK_S).told_ms

    async def _press(self, way: str) -> None:
        if way == "channel":
            self.observer.say(type="stop")
            return
        with suppress(SignallingError, TimeoutError, aiohttp.ClientError):
            await self.observer.press_stop()

    async def _hold_still(self) -> None:
        steering, self._steering = self._steering, None
        if steering is not None:
            steering.cancel()
            await asyncio.gather(steering, return_exceptions=True)

    def _frames(self) -> int:
        return self.operator.media.counts("video").frames

    async def _newcomers(self) -> None:
        """Ask for a page now and then as somebody who has never been here does."""
        while True:
            began_s = time.monotonic()
            answer = await ask(
                self.stage.server.port, "GET", "/", source=NEWCOMER, within_s=_SERVED_S
            )
            if answer.status != 200:
                self._unserved_s.append(began_s)
            await asyncio.sleep(_NEWCOMER_S)

    async def _remember(self) -> None:
        while True:
            self.peak_mib = max(self.peak_mib, self._meter.rss_mib())
            await asyncio.sleep(_LOOK_S)


async def begin(attackers: Strangers, name: str, seconds: float, seed: int = 0) -> None:
    """Let the attackers begin; their account comes when the time is over."""
    await attackers.say(f"{name} {seconds} {seed}")
    await attackers.line()


async def attacked(
    name: str,
    seconds: float,
    stops: int,
    *tables: Mapping[str, Any],
    load: Load = AS_SHIPPED,
    seed: int = 0,
) -> Seen:
    """Drive for so long without the attack, as long under it, and then press Stop `stops` times."""
    async with (
        staged(toml.as_shipped(), STOPS_AT_EACH_TRIAL, *tables, load=load) as stage,
        RawOperator(stage.server, sees=True) as operator,
        RawOperator(stage.server) as observer,
        Watch(stage, operator, observer) as watch,
        strangers("attacks", stage.server.port) as attackers,
    ):
        await operator.join()
        await watch.steer()
        await asyncio.sleep(_SETTLE_S)
        quiet = await watch.window(seconds)
        lasts_s = seconds + stops * _TRIAL_S
        await begin(attackers, name, lasts_s, seed)
        before_mib = watch.mib()
        during = await watch.window(seconds)
        stops_ms = await watch.stops(stops, during.since_s + lasts_s)
        account = await attackers.account(lasts_s + 4 * _PATIENCE_S)
        watch.fill(quiet)
        normal_ms = MORE_MS + (of(quiet.round_trips_ms, "p99") or 0.0)
        normal_s = await watch.trips.normal_after(time.monotonic(), normal_ms)
        peak_mib = watch.peak_mib
        after_mib = await watch.settled_mib(before_mib + MORE_MIB)
        watch.fill(during)
    return Seen(quiet, during, stops_ms, normal_s, before_mib, peak_mib, after_mib, account)


def of(values: Iterable[float | None], name: str) -> float | None:
    """Return a figure of those that came; None where none did."""
    came = [value for value in values if value is not None]
    return getattr(summarize(came), name) if came else None


async def hostile(
    name: str,
    n: int,
    *,
    tables: Iterable[Mapping[str, Any]] = (),
    load: Load = AS_SHIPPED,
    key: str = "hostile",
) -> list[Row]:
    """Measure one attack for `n` seconds and as many Stops; WAX_SEED repeats what chance drew."""
    seed = int(os.environ.get("WAX_SEED") or random.randrange(2**32))
    seen = await attacked(name, n, n, *tables, load=load, seed=seed)
    found = rows(name, seen, n, key=key)
    missed = [*found[0].detail["what_was_wrong"], *(row.key for row in found if not row.met)]
    verdict = f"*missed*: {', '.join(missed)}" if missed else "met"
    print(f"\n{key}-{line(name, seen)}; WAX_SEED={seed}: {verdict}", flush=True)
    return found


def rows(name: str, seen: Seen, presses: int, *, key: str = "hostile") -> list[Row]:
    """Judge what was seen: what the operator has of it, with all that must not be, and Stop."""
    quiet, during = seen.quiet, seen.during
    quiet_p99 = of(quiet.round_trips_ms, "p99")
    if quiet_p99 is None:
        raise MeasureError(f"{name}: no ping was answered before the attack")
    wrong = {
        "too few Stops before its end": sum(map(len, seen.stops_ms.values())) < presses,
        "the robot stopped": during.stands > 0,
        "fewer pictures": during.fps < FPS_SHARE * quiet.fps,
        "more memory": seen.peak_mib - seen.before_mib > MORE_MIB,
        "newcomers were not served": during.unserved > 0,
        "late after it": seen.normal_s is None or seen.normal_s > NORMAL_S,
    }
    return [
        summed(
            f"{key}-{name}",
            f"{ATTACKS[name].what}: ping → pong of the operator (before: p99 {quiet_p99:.1f} ms)",
            "ms",
            during.round_trips_ms,
            quiet_p99 + MORE_MS,
            judged="p99",
            wrong=sum(wrong.values()),
            what_was_wrong=[what for what, is_so in wrong.items() if is_so],
            line=line(name, seen),
        ),
        *(
            summed(
                f"{key}-{name}: Stop by {way}",
                f"… an observer’s Stop by {way} → stop frame",
                "ms",
                took,
                STOP_MS,
                judged="p99",
            )
            for way, took in seen.stops_ms.items()
            if took
        ),
    ]


def line(name: str, seen: Seen) -> str:
    """Return one line for people, with what is judged by its goal; times are p50/p99/max in ms."""

    def ms(values: Sequence[float | None]) -> str:
        found = [of(values, one) for one in ("median", "p99", "max")]
        said = "/".join("-" if one is None else f"{one:.0f}" for one in found)
        never = list(values).count(None)
        return said + (f" ({never} of {len(values)} never)" if never else "")

    stops = ", ".join(f"{way} {ms(took)} n={len(took)}" for way, took in seen.stops_ms.items())
    quiet, during = seen.quiet, seen.during
    goal_ms = MORE_MS + (of(quiet.round_trips_ms, "p99") or 0.0)
    account = {what: said for what, said in seen.account.items() if what != "drawn"}
    return (
        f"{name}: ping {ms(quiet.round_trips_ms)} → {ms(during.round_trips_ms)}"
        f" (goal p99 {goal_ms:.0f});"
        f" command {ms(quiet.commands_ms)} → {ms(during.commands_ms)};"
        f" stops {quiet.stands} → {during.stands} (0); unserved {during.unserved} (0);"
        f" fps {quiet.fps:.1f} → {during.fps:.1f} ({FPS_SHARE * quiet.fps:.1f});"
        f" beat late {quiet.beat_ms} → {during.beat_ms} ms, operator's own timer"
        f" {during.own_late_ms:.0f} ms; Stop {stops} ({STOP_MS:.0f}); normal after"
        f" {-1.0 if seen.normal_s is None else seen.normal_s:.2f} s ({NORMAL_S:.0f});"
        f" MiB {seen.before_mib:.0f} → {seen.peak_mib:.0f} → {seen.after_mib:.0f}"
        f" (+{MORE_MIB:.0f}); {json.dumps(account)}"
    )
