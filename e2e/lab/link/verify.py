"""The link against its own profiles: real packets through the real devices, at most 10 s each.

Three trains in both directions at once: spaced packets for delay, jitter, stalls; dense small ones
for loss, where there is any; more than the rate for rate and queue, through all changes. Two
things differ from the profile, so that it fits the time: stalls come at least every 0.8 s and
changes each 1.5 s.
"""

from __future__ import annotations

import asyncio
import time
from asyncio.subprocess import PIPE
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from pydantic import TypeAdapter

from e2e.lab.link import expect
from e2e.lab.link.chance import StallClock, jitter_quantile_ms, seeded
from e2e.lab.link.errors import LinkError
from e2e.lab.link.link import End, Link
from e2e.lab.link.probe import Plan, Record, Train
from e2e.lab.link.profile import Profile, load
from e2e.lab.link.trace import TraceTransmitter, read

if TYPE_CHECKING:
    from e2e.lab.link.expect import Figure
    from e2e.lab.link.profile import DirectionSettings
    from e2e.lab.link.statistics import Statistics

CARRIED_BPS: Final = 25_000_000
"""A rate above it is not filled: the emulator is in Python."""

_SMALL_BYTES: Final = 60
_SPACED_S: Final = 3.6
_DENSE_S: Final = 1.6
_DENSE_PPS: Final = 2000
_FULL_S: Final = 2.8
_CHANGE_EVERY_S: Final = 1.5
_STALL_EVERY_S: Final = 0.8
_OVERLOAD: Final = 1.25
_FILLING: Final = 3.0
"""At first so many times the rate, until the queue is full."""
_SETTLE_S: Final = 0.3
_RECORD: Final = TypeAdapter(Record)
_PLAN: Final = TypeAdapter(Plan)

WayName = Literal["down", "up"]
WAYS: Final[tuple[WayName, WayName]] = ("down", "up")


@dataclass(frozen=True, slots=True)
class Verified:
    """What was found for one profile."""

    profile: str
    took_s: float
    figures: dict[WayName, list[Figure]]
    notes: list[str]
    statistics: Statistics

    @property
    def ok(self) -> bool:
        return all(figure.ok for figures in self.figures.values() for figure in figures)


@dataclass(frozen=True, slots=True)
class _Times:
    """When the trains begin and when the changes do, monotonic."""

    spaced_s: float
    dense_s: float
    full_s: float
    end_s: float


async def verify(name: str) -> Verified:
    """Measure one profile. Raises `LinkError`."""
    began_s = time.monotonic()
    profile = _shortened(load(name))
    async with Link(profile) as link:
        times = _times(profile, time.monotonic() + 0.5)
        records = await asyncio.gather(
            _run(link.server, link.browser, _plan(profile.down, times)),
            _run(link.browser, link.server, _plan(profile.up, times)),
            _change(link, times.full_s),
        )
        statistics = await link.statistics()
    down, up, _ = records
    seen = {"down": (down, up), "up": (up, down)}
    notes: list[str] = []
    figures: dict[WayName, list[Figure]] = {}
    for way in WAYS:
        judge = _Judge(profile, way, times, link.start_s, *seen[way])
        figures[way] = judge.figures(notes)
    return Verified(name, time.monotonic() - began_s, figures, notes, statistics)


def _shortened(profile: Profile) -> Profile:
    """Bring stalls and changes into the time that there is."""
    ways = {}
    for way in WAYS:
        settings: DirectionSettings = getattr(profile, way)
        update: dict[str, object] = {}
        if settings.stalls is not None:
            every_s = min(settings.stalls.every_s, _STALL_EVERY_S)
            update["stalls"] = settings.stalls.model_copy(update={"every_s": every_s})
        if settings.changes:
            update["changes"] = [
                change.model_copy(update={"at_s": (index + 1) * _CHANGE_EVERY_S})
                for index, change in enumerate(settings.changes)
            ]
        ways[way] = settings.model_copy(update=update)
    return profile.model_copy(update=ways)


def _times(profile: Profile, begin_s: float) -> _Times:
    slowest_s = max(_latest_s(profile.down), _latest_s(profile.up))
    changes = max(len(profile.down.changes), len(profile.up.changes))
    losses = max(profile.down.loss.mean, profile.up.loss.mean) > 0
    dense_s = begin_s + _SPACED_S + slowest_s
    full_s = dense_s + (_DENSE_S + slowest_s if losses else 0.0)
    full_for_s = (changes + 1) * _CHANGE_EVERY_S if changes else _FULL_S
    queues_s = max(_queue_s(profile.down), _queue_s(profile.up))
    return _Times(begin_s, dense_s, full_s, full_s + full_for_s + slowest_s + queues_s)


def _latest_s(settings: DirectionSettings) -> float:
    """Return how late a packet can be that does not queue."""
    stall_ms = settings.stalls.at_most_ms if settings.stalls else 0.0
    jitter_ms = jitter_quantile_ms(settings.jitter, 1.0)
    return (settings.delay_ms + jitter_ms + stall_ms) / 1000 + _SETTLE_S


def _mean_bps(settings: DirectionSettings) -> float | None:
    if settings.trace is not None:
        return TraceTransmitter(read(settings.trace), 0.0).mean_bps
    return settings.rate_bps


def _queue_s(settings: DirectionSettings) -> float:
    rate_bps = _mean_bps(settings)
    if rate_bps is None or rate_bps > CARRIED_BPS:
        return 0.0
    if settings.queue_ms is not None:
        return settings.queue_ms / 1000
    return (settings.queue_bytes or 0) * 8 / rate_bps


def _spacing_s(settings: DirectionSettings) -> float:
    """Return a distance at which jitter hardly makes a packet wait for the one before."""
    width_ms = jitter_quantile_ms(settings.jitter, 0.98) - jitter_quantile_ms(settings.jitter, 0.02)
    return min(max(width_ms, 10.0), 60.0) / 1000


def _full_bytes(rate_bps: float) -> int:
    """Return a packet size of which enough come in the time."""
    return 1200 if rate_bps >= 500_000 else 300


def _plan(settings: DirectionSettings, times: _Times) -> Plan:
    spaced = Train(
        times.spaced_s, times.spaced_s + _SPACED_S, _spacing_s(settings), _SMALL_BYTES
    )
    trains = [spaced]
    rate_bps = _mean_bps(settings)
    if times.full_s > times.dense_s:
        fastest_pps = min(_DENSE_PPS, (rate_bps or CARRIED_BPS) / 2 / (_SMALL_BYTES * 8))
        end_s = times.dense_s + _DENSE_S
        trains.append(Train(times.dense_s, end_s, 1 / fastest_pps, _SMALL_BYTES))
    if rate_bps is not None and rate_bps <= CARRIED_BPS:
        size_bytes = _full_bytes(rate_bps)
        interval_s = size_bytes * 8 / rate_bps
        filled_s = times.full_s + 1.1 * _queue_s(settings) / (_FILLING - 1)
        end_s = times.full_s + max(_FULL_S, _CHANGE_EVERY_S * (len(settings.changes) + 1))
        trains.append(Train(times.full_s, filled_s, interval_s / _FILLING, size_bytes))
        trains.append(Train(filled_s, end_s, interval_s / _OVERLOAD, size_bytes))
    return Plan(trains, times.end_s)


async def _run(here: End, there: End, plan: Plan) -> Record:
    arguments = ("-m", "e2e.lab.link.probe", here.address, there.address)
    process = await here.spawn_python(arguments, stdin=PIPE, stdout=PIPE)
    out, _ = await process.communicate(_PLAN.dump_json(plan))
    if process.returncode != 0:
        raise LinkError(f"the probe at {here.address} failed; its words are on standard error")
    return _RECORD.validate_json(out)


async def _change(link: Link, at_s: float) -> None:
    await asyncio.sleep(at_s - time.monotonic())
    await link.start_changes()


class _Judge:
    """One direction's records against its settings."""

    def __init__(
        self, profile: Profile, way: WayName, times: _Times, start_s: float, sent: Record, came: Record
    ) -> None:
        self._settings: DirectionSettings = getattr(profile, way)
        self._way = way
        self._times = times
        self._stalls = StallClock(seeded(profile.seed, way, "stalls"), start_s)
        self._sent_s = sent.sent_s
        self._came = came.came

    def figures(self, notes: list[str]) -> list[Figure]:
        settings = self._settings
        figures = self._delays(notes)
        begin_s, end_s = self._times.dense_s, self._times.full_s
        if end_s == begin_s:
            begin_s = self._times.spaced_s
        sent = sum(begin_s <= sent_s < end_s for sent_s in self._sent_s)
        came = sum(begin_s <= sent_s < end_s for _, sent_s, _ in self._came)
        figures.append(expect.loss_figure(settings.loss, sent, came))
        figures += self._rates(notes)
        if settings.reorder:
            notes.append(f"{self._way}: order is not kept, as the profile asks")
        else:
            numbers = [number for number, _, _ in self._came]
            overtaken = sum(
                later < earlier for earlier, later in zip(numbers, numbers[1:], strict=False)
            )
            figures.append(expect.Figure("overtaken", 0.0, overtaken, 0.0))
        return figures

    def _delays(self, notes: list[str]) -> list[Figure]:
        """Judge the spaced packets; what a stall held, which the seed tells, is judged apart."""
        settings = self._settings
        rate_bps = settings.rate_bps
        base_ms = settings.delay_ms + (_SMALL_BYTES * 8000 / rate_bps if rate_bps else 0.0)
        free_ms, held_ms, stalled_ms = [], [], []
        touched_s = 0.0
        for _, sent_s, came_s in self._came:
            if sent_s >= self._times.dense_s:
                continue
            leaves_s = sent_s + base_ms / 1000 - settings.delay_ms / 1000
            released_s = self._stalls.release_s(settings.stalls, leaves_s)
            if released_s > leaves_s:
                held_ms.append((released_s - leaves_s) * 1000)
                stalled_ms.append((came_s - sent_s) * 1000)
                touched_s = released_s + jitter_quantile_ms(settings.jitter, 1.0) / 1000
            elif leaves_s >= touched_s:
                free_ms.append((came_s - sent_s) * 1000)
        if settings.trace is not None:
            notes.append(f"{self._way}: delay and jitter are the trace's, so they are not judged")
            return []
        figures = [
            expect.delay_figure(base_ms, settings.jitter, free_ms),
            expect.jitter_figure(settings.jitter, free_ms),
        ]
        if settings.stalls is not None and held_ms:
            # Behind a stall packets come together, in order: with the latest of their jitters.
            own_ms = base_ms + jitter_quantile_ms(settings.jitter, 0.5)
            promised_ms = sum(held_ms) / len(held_ms)
            measured_ms = sum(stalled_ms) / len(stalled_ms) - own_ms
            spread_ms = jitter_quantile_ms(settings.jitter, 0.98) - jitter_quantile_ms(
                settings.jitter, 0.5
            )
            figures.append(
                expect.time_figure("stall_ms", promised_ms, measured_ms, spread_ms / 2)
            )
        return figures

    def _rates(self, notes: list[str]) -> list[Figure]:
        settings = self._settings
        rate_bps = _mean_bps(settings)
        if rate_bps is None or rate_bps > CARRIED_BPS:
            notes.append(
                f"{self._way}: the rate is above {CARRIED_BPS / 1e6:g} Mbit/s, so it is not filled"
            )
            return []
        size_bytes = _full_bytes(rate_bps)
        guard_s = 0.1
        steps = settings.steps()
        ends_s = [at_s for at_s, _ in steps[1:]] + [max(_FULL_S, _CHANGE_EVERY_S * len(steps))]
        figures = []
        for (at_s, conditions), end_s in zip(steps, ends_s, strict=True):
            # From when the queue's first packets have come, until its last ones have not yet.
            first_s = self._times.full_s + at_s + conditions.delay_ms / 1000 + guard_s
            last_s = self._times.full_s + end_s + conditions.delay_ms / 1000 - guard_s
            inside = [
                (came_s, size_bytes)
                for _, sent_s, came_s in self._came
                if sent_s >= self._times.full_s and first_s <= came_s < last_s
            ]
            promised = _mean_bps(settings) if settings.trace else conditions.rate_bps
            promised = 0.0 if conditions.outage else (promised or 0.0) * (1 - conditions.loss.mean)
            name = "rate_bps" if len(steps) == 1 else f"rate_bps from step {len(figures)}"
            allowed = expect.SHARE * promised
            figures.append(expect.Figure(name, promised, expect.rate_bps(inside), allowed))
        if not settings.changes and settings.trace is None:
            figures.append(self._queue(size_bytes, rate_bps))
        return figures

    def _queue(self, size_bytes: int, rate_bps: float) -> Figure:
        """Judge how long packets wait at most: the delay of those that meet a full queue."""
        settings = self._settings
        full_s = self._times.full_s + _FULL_S * 0.6
        waits_ms = [
            (came_s - sent_s) * 1000 for _, sent_s, came_s in self._came if sent_s >= full_s
        ]
        packet_ms = size_bytes * 8000 / rate_bps
        own_ms = settings.delay_ms + jitter_quantile_ms(settings.jitter, 0.5)
        measured_ms = expect.quantile(waits_ms, 0.5) - own_ms
        # A queue is full when one more packet does not fit, so it is up to one short of full.
        return expect.time_figure(
            "queue_ms", _queue_s(settings) * 1000 - packet_ms / 2, measured_ms, packet_ms / 4
        )
