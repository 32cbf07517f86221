"""Strangers attack while one person drives, and another watches and presses Stop."""

from __future__ import annotations

import asyncio
import json
import math
import os
import random
import time
import tomllib
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import cycle, islice, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

import aiohttp
import psutil

from e2e.harness import toml
from e2e.load.process import ProcessMeter
from e2e.measure.errors import MeasureError
from e2e.measure.row import counted, summarize, summed, timed
from e2e.measure.suite import ROOT
from e2e.stop.operator import RawOperator
from e2e.stop.stage import DEFAULT, STOPS_AT_EACH_TRIAL, Load, staged
from e2e.strangers.ground import address, strangers
from e2e.strangers.intruder import ask
from e2e.strangers.steps import WITH_STEPS, long_steps
from wax.errors import SignallingError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from e2e.harness.child import Child
    from e2e.measure.row import Row
    from e2e.stop.stage import Stage
    from e2e.strangers.steps import Step

MORE_MS: Final = 10.0
FPS_SHARE: Final = 0.95
STOP_MS: Final = 100.0
MORE_MIB: Final = 20.0
KEPT_MIB: Final = 5.0
STEP_MS: Final = 5.0
"""On the slowest runner; 2 ms on a core like this one."""
HOST_S: Final = 5.0
GUEST_S: Final = 1.0
CLOSED_S: Final = 10.0
STOPS: Final = 6
"""A hundred in all attacks together."""

WAYS: Final = ("HTTP", "channel")
_SPEEDS: Final = (0.15, 0.25)
"""Shares of full speed: below any limit, and so close that the ramp takes two periods."""
_PAUSE_S: Final = (0.12, 0.18)
_QUIET_S: Final = 20.0
_PATIENCE_S: Final = 15.0
_LOOK_S: Final = 0.1
_SETTLE_S: Final = 2.0
_KEPT_S: Final = 10.0
_TRIAL_S: Final = 1.5
NEWCOMER: Final = address(240)
_NEWCOMER_S: Final = 0.25
_SERVED_S: Final = 3.0
_SILENT_S: Final = 0.1
"""Commands are due every 20 ms; after 150 ms without one the robot stops."""
_STEPS: Final = 5
_SHORTEST_S: Final = 11.0
"""How long the attack by slow connections must last until the server can close the last."""

AS_SHIPPED: Final = replace(DEFAULT, observers=0)


def public_robot() -> tuple[Mapping[str, Any], Load]:
    """Return `config/public-robot.toml`, with a test card as its camera, and the load on it."""
    tree = tomllib.loads((ROOT / "config/public-robot.toml").read_text(encoding="utf-8"))
    # The stage's board replaces its robot; here the first who joins drives at once, to the end.
    del tree["robot"]["driver"], tree["robot"]["serial"]["url"]
    tree["turns"] = {"max_waiting_per_address": tree["turns"]["max_waiting_per_address"]}
    media = {"video": tree.pop("video") | {"source": "testcard"}, "audio": tree.pop("audio")}
    return tree, Load("config/public-robot.toml", media, 0)


@dataclass(slots=True)
class Seen:
    """What a look at the robot and its server showed; None for what never came."""

    since_s: float
    until_s: float = 0.0
    fps: float = 0.0
    commands_ms: Sequence[float | None] = ()
    stands: int = 0
    """How often the robot stopped by itself."""
    reasons: Sequence[str] = ()
    """The reasons, told to the operator's page, for standing still or driving slower."""
    unserved: int = 0
    """The number of newcomers who got no answer."""
    more_mib: float = 0.0
    stops_ms: Sequence[float | None] = ()
    host_s: float | None = None
    """How long the host took to join during the attack."""
    guest_s: float | None = None
    """How long a guest took to join after it."""
    account: Mapping[str, Any] = field(default_factory=dict)
    steps: Sequence[Step] = ()
    """The event loop's long steps, if the server logs them."""

    @property
    def harm(self) -> list[str]:
        """What no attack may cause, however short the look."""
        wrong = {
            f"the robot stopped {self.stands} times": self.stands > 0,
            f"{self.unserved} newcomers were not served": self.unserved > 0,
            f"memory grew by {self.more_mib:.0f} MiB": self.more_mib > MORE_MIB,
        }
        harm = [what for what, is_so in wrong.items() if is_so]
        return harm + [f"the operator was told: {reason}" for reason in self.reasons if harm]


class Watch:
    """An async context manager that steers, presses Stop and observes the robot."""

    def __init__(self, stage: Stage, operator: RawOperator, observer: RawOperator) -> None:
        self.stage = stage
        self.operator = operator
        self.observer = observer
        self._changed_s: list[float] = []
        self._unserved_s: list[float] = []
        self._waits: list[tuple[float, float]] = []
        self._meter = ProcessMeter(stage.server.pid)
        self._peak_mib = 0.0
        self._tasks: list[asyncio.Task[None]] = []
        self._steering: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        works = (self._remember(), self._newcomers())
        self._tasks = [asyncio.create_task(work) for work in works]
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._hold_still()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def look(self, seconds: float) -> Seen:
        """Drive at changing speed for `seconds`; raises `MeasureError` if that is impossible."""
        await self._steers()
        seen, frames = Seen(time.monotonic()), self._frames()
        await asyncio.sleep(seconds)
        seen.until_s = time.monotonic()
        seen.fps = (self._frames() - frames) / (seen.until_s - seen.since_s)
        return seen

    async def attacked(
        self, gang: Child, name: str, seconds: float, *, stops: int, stops_s: float, seed: int = 0
    ) -> Seen:
        """Drive for `seconds` under an attack, then press Stop, each way in turn, for `stops_s`."""
        await self._steers()
        await gang.say(f"{name} {seconds + stops_s} {seed}")
        await gang.line()  # it has begun
        self._peak_mib = before_mib = self._meter.rss_mib()
        logged = len(self.stage.server.log)
        seen = await self.look(seconds)
        seen.stops_ms = await self.stops(stops, seen.until_s + stops_s)
        seen.account = json.loads(await gang.line(seconds + stops_s + 4 * _PATIENCE_S))
        seen.more_mib = self._peak_mib - before_mib
        seen.steps = long_steps(self.stage.server.log[logged:])
        return self.filled(seen)

    def filled(self, seen: Seen) -> Seen:
        """Add what is known only after late answers have arrived."""
        seen.commands_ms = self._commands_ms(seen.since_s, seen.until_s)
        seen.stands = self.stands(seen.since_s, seen.until_s)
        heard = self.operator.reasons
        seen.reasons = [why for at_s, why in heard if seen.since_s <= at_s <= seen.until_s]
        seen.unserved = sum(seen.since_s <= at_s <= seen.until_s for at_s in self._unserved_s)
        return seen

    def stands(self, since_s: float, until_s: float) -> int:
        """Count how often the robot stopped, by a frame or by its own watchdog.

        Stops do not count after the operator's own silence, or while server or driver waited for a
        processor, since they share this machine with the attackers.
        """
        record = self.stage.record
        record.read()
        frames = record.between(since_s, until_s)
        stopped_s = [after.at_s for before, after in pairwise(frames) if before.moves > after.moves]
        stopped_s += [at_s for at_s in record.expiries_s if since_s < at_s <= until_s]
        sent_s = [one.at_s for one in self.operator.sent_before]
        silences = [(a, b) for a, b in pairwise(sent_s) if b - a > _SILENT_S]
        silences += self._waits
        return sum(not any(a < at_s < b + _SILENT_S for a, b in silences) for at_s in stopped_s)

    def socket_of(self, viewer: RawOperator) -> tuple[Any, tuple[str, int]]:
        """Return the socket of a viewer's peer, and the address that it sends to."""
        association: Any = viewer.peer.sctp
        pair = association.transport.transport._connection._nominated[1]
        return pair.protocol.transport, pair.remote_addr

    async def _steers(self) -> None:
        if self._steering is None:
            await self.stage.drive(self.operator)
            self._steering = asyncio.create_task(self._steer())

    async def _steer(self) -> None:
        """Change the speed at a random phase; if the robot was stopped, press again, as people do.

        A late frame is no stop: letting go because of it would make one.
        """
        for speed in cycle(_SPEEDS):
            self.stage.record.read()
            if not self.stage.record.frames[-1].moves:
                with suppress(MeasureError):
                    await self.stage.drive(self.operator)
            self.operator.steer(speed)
            self._changed_s.append(time.monotonic())
            self.operator.command()
            await asyncio.sleep(random.uniform(*_PAUSE_S))

    def _commands_ms(self, since_s: float, until_s: float) -> list[float | None]:
        """Return the ms from each change to the first frame that shows it; None if none does."""
        frames = self.stage.record.between(since_s - 1.0, until_s + _SETTLE_S)
        found: list[float | None] = []
        for changed_s in self._changed_s:
            if since_s <= changed_s <= until_s:
                before = [one.left_mmps for one in frames if one.at_s < changed_s][-1:]
                after = (one for one in frames if one.at_s >= changed_s)
                shown_s = next((one.at_s for one in after if [one.left_mmps] != before), None)
                found.append(None if shown_s is None else (shown_s - changed_s) * 1000)
        return found

    async def stops(self, number: int, until_s: float) -> list[float | None]:
        """Press Stop up to `number` times before `until_s`; return the ms until each stop frame.

        If the robot stands already, return the ms until the operator's page was told.
        """
        await self._hold_still()
        found: list[float | None] = []
        for way in islice(cycle(WAYS), number):
            if time.monotonic() < until_s:
                with suppress(MeasureError):
                    await self.stage.drive(self.operator)
                found.append(await self._stop(way))
        return found

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
        await asyncio.sleep(_LOOK_S)  # the board's log lags by a frame
        for _ in range(int(_PATIENCE_S)):  # a release that comes late is refused
            operator.release(stop)
            if await operator.until(lambda: operator.stopped is None, 1.0):
                break
        record.read()
        if not moved:
            return (told_s - since_s) * 1000
        return record.stopping(since_s, told_s + _LOOK_S).told_ms

    async def _press(self, way: str) -> None:
        if way == "channel":
            self.observer.send(type="stop")
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
        """Request the page now and then, as somebody new does."""
        while True:
            began_s = time.monotonic()
            answer = await ask(
                self.stage.server.port, "GET", "/", source=NEWCOMER, within_s=_SERVED_S
            )
            if answer.status != 200:
                self._unserved_s.append(began_s)
            await asyncio.sleep(_NEWCOMER_S)

    async def _remember(self) -> None:
        pids, waited_s = (self.stage.server.pid, self.stage.driver_pid), math.inf
        while True:
            self._peak_mib = max(self._peak_mib, self._meter.rss_mib())
            before_s, waited_s = waited_s, sum(map(_waited_s, pids))
            if (wait_s := waited_s - before_s) > _LOOK_S:
                now_s = time.monotonic()
                self._waits.append((now_s - _LOOK_S - wait_s, now_s))
            await asyncio.sleep(_LOOK_S)


def _waited_s(pid: int) -> float:
    """Return how long a process has waited for a processor in all; 0 if it has ended."""
    with suppress(OSError):
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    return 0.0


async def hostile(
    n: float, names: Sequence[str], key: str, table: Mapping[str, Any], load: Load
) -> list[Row]:
    """Run each attack for `n` seconds and six Stops; WAX_SEED repeats the random choices.

    With WAX_STEPS=1 the server logs its long steps, which costs it some percent of a core.
    """
    if os.environ.get("WAX_STEPS"):
        table = toml.merged(table, WITH_STEPS)
    seed = int(os.environ.get("WAX_SEED") or random.randrange(2**32))
    async with (
        staged(toml.as_shipped(), STOPS_AT_EACH_TRIAL, table, load=load) as stage,
        RawOperator(stage.server, sees=True) as operator,
        RawOperator(stage.server) as observer,
        Watch(stage, operator, observer) as watch,
        strangers("attacks", stage.server.port) as gang,
        strangers("joiner", stage.server.url, stage.server.state_folder) as joiner,
    ):
        await operator.join()
        # What is loaded or opened for the first of each must not count for an attack.
        for who in ("host", "guest"):
            await _join(joiner, who)
        await watch.stops(len(WAYS), time.monotonic() + _PATIENCE_S)
        await watch.look(_SETTLE_S)
        quiet, found = watch.filled(await watch.look(_QUIET_S)), dict[str, Seen]()
        process, meter = psutil.Process(stage.server.pid), ProcessMeter(stage.server.pid)
        before, before_mib = process.num_fds(), meter.rss_mib()
        steps = (await stage.server.status())["steps"]
        for name in names:
            lasts_s = max(STOPS * _TRIAL_S, (_SHORTEST_S - n) * (name == "slow"))
            coming = asyncio.create_task(_join(joiner, "host", after_s=n / 2))
            seen = await watch.attacked(gang, name, n, stops=STOPS, stops_s=lasts_s, seed=seed)
            seen.host_s, seen.guest_s = await coming, await _join(joiner, "guest")
            found[name] = seen
            print(f"{key}, {_line(name, seen)}", _wrong(seen, quiet) or "", flush=True)
        await asyncio.sleep(_KEPT_S)
        kept_mib = meter.rss_mib() - before_mib
        left = await _left(process, before)
        longest_ms = _longer_ms(steps, (await stage.server.status())["steps"])
    print(f"WAX_SEED={seed}", flush=True)
    return [
        *rows(key, load, quiet, found, left),
        summed(f"{key}: kept", "… memory that is kept for 10 s", "MiB", [kept_mib], KEPT_MIB),
        timed(
            f"{key}: longest",
            "… longest step of each part of the event loop, with its waits for a core",
            list(longest_ms.values()) or [0.0],
            STEP_MS,
            parts=longest_ms,
        ),
    ]


def _longer_ms(
    before: Mapping[str, Mapping[str, float]], after: Mapping[str, Mapping[str, float]]
) -> dict[str, float]:
    """Return the longest step of each part that had one longer than ever before."""
    nothing = {"longest_ms": 0.0}
    return {
        part: one["longest_ms"]
        for part, one in after.items()
        if one["longest_ms"] > before.get(part, nothing)["longest_ms"]
    }


def _wrong(seen: Seen, quiet: Seen) -> list[str]:
    fewer = seen.fps < FPS_SHARE * quiet.fps
    lacking = len(seen.stops_ms) < STOPS
    return seen.harm + ["fewer pictures"] * fewer + ["too few Stops before its end"] * lacking


def _line(name: str, seen: Seen) -> str:
    """Return a readable line of what was seen, with times as median/longest."""

    def ms(values: Iterable[float | None]) -> str:
        came = [value for value in values if value is not None]
        spread = summarize(came) if came else None
        return "-" if spread is None else f"{spread.median:.0f}/{spread.max:.0f} ms"

    account = {what: said for what, said in seen.account.items() if what != "lasted_s"}
    return (
        f"{name}: command {ms(seen.commands_ms)}, Stop {ms(seen.stops_ms)}, {seen.fps:.1f} fps,"
        f" {seen.more_mib:+.0f} MiB; {json.dumps(account)}"
        + "".join(f"\n  {step}" for step in seen.steps[:_STEPS])
    )


def rows(key: str, load: Load, quiet: Seen, found: Mapping[str, Seen], left: int) -> list[Row]:
    """Judge all attacks together: their effect on the operator, on Stop, and on who joins.

    `left` are the descriptors that are open after all of them and were not before.
    """
    quiet_ms = [ms for ms in quiet.commands_ms if ms is not None]
    if not quiet_ms:
        raise MeasureError(f"{key}: no command arrived before the attacks")
    quiet_p99_ms = summarize(quiet_ms).p99
    every = found.values()
    wrong = {name: harm for name, seen in found.items() if (harm := _wrong(seen, quiet))}
    if left:
        wrong["all"] = [f"{left} descriptors left"]
    joins_s = {HOST_S: [one.host_s for one in every], GUEST_S: [one.guest_s for one in every]}
    late = [s for most_s, took_s in joins_s.items() for s in took_s if s is None or s > most_s]
    steps_ms = [step.processor_ms for seen in every for step in seen.steps]
    lasted_s = [s for seen in every for kind in seen.account["lasted_s"].values() for s in kind]
    judged = [
        summed(
            key,
            f"{load.what}, {len(every)} attacks: command → frame (before: p99 {quiet_p99_ms:.0f})",
            "ms",
            [ms for seen in every for ms in seen.commands_ms],
            quiet_p99_ms + MORE_MS,
            judged="p99",
        ),
        timed(
            f"{key}: Stop",
            "… an observer’s Stop, by HTTP and by the data channel → stop frame",
            [ms for seen in every for ms in seen.stops_ms],
            STOP_MS,
        ),
        counted(
            f"{key}: wrong",
            "… attacks that stopped it, kept a newcomer out for 3 s,"
            " or cost pictures, memory or files",
            len(wrong),
            len(every),
            **wrong,
        ),
        counted(
            f"{key}: joins",
            "… joins that took longer, the host’s meanwhile"
            f" than {HOST_S:g} s, a guest’s afterwards than {GUEST_S:g} s",
            len(late),
            2 * len(every),
            seconds={f"{most_s:g}": took_s for most_s, took_s in joins_s.items()},
        ),
    ]
    if steps_ms:
        what = "… steps of the event loop above 2 ms, of its own processor time"
        judged.append(timed(f"{key}: steps", what, steps_ms, STEP_MS))
    if lasted_s:
        what = "… slow connections are closed after"
        judged.append(summed(f"{key}: slow", what, "s", lasted_s, CLOSED_S))
    return judged


async def _join(joiner: Child, who: str, *, after_s: float = 0.0) -> float | None:
    """Let somebody join after a while, and leave; return how many seconds joining took."""
    await asyncio.sleep(after_s)
    await joiner.say(who)
    took_s: float | None = json.loads(await joiner.line())["took_s"]
    return took_s


async def _left(process: psutil.Process, before: int) -> int:
    """Return how many more descriptors are open than before, after time to close them."""
    for _ in range(int(_PATIENCE_S / _LOOK_S)):
        if (left := max(int(process.num_fds()) - before, 0)) == 0:
            break
        await asyncio.sleep(_LOOK_S)
    return left
