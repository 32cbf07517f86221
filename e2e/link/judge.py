"""What came of the trains, held against the settings of its direction; pure."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from tests.link.chance import StallClock, jitter_quantile_ms, seeded

from e2e.link import expect
from e2e.link.trains import (
    CARRIED_BPS,
    CHANGE_EVERY_S,
    FULL_S,
    SMALL_BYTES,
    full_bytes,
    mean_bps,
    queue_s,
)

if TYPE_CHECKING:
    from tests.link.profile import DirectionSettings, Profile

    from e2e.link.expect import Figure
    from e2e.link.probe import Record
    from e2e.link.trains import Timetable, WayName


class Judge:
    """One direction's records against its settings."""

    def __init__(
        self,
        profile: Profile,
        way: WayName,
        timetable: Timetable,
        *,
        start_s: float,
        sent: Record,
        came: Record,
    ) -> None:
        self._settings: DirectionSettings = getattr(profile, way)
        self._way = way
        self._timetable = timetable
        self._stalls = StallClock(seeded(profile.seed, way, "stalls"), start_s)
        self._sent_s = sent.sent_s
        self._came = came.came

    def figures(self, notes: list[str]) -> list[Figure]:
        settings = self._settings
        figures = self._delays(notes)
        begin_s, end_s = self._timetable.dense_s, self._timetable.full_s
        if end_s == begin_s:
            begin_s = self._timetable.spaced_s
        sent = sum(begin_s <= sent_s < end_s for sent_s in self._sent_s)
        came = sum(begin_s <= sent_s < end_s for _, sent_s, _ in self._came)
        figures.append(expect.loss_figure(settings.loss, sent, came))
        figures += self._rates(notes)
        if settings.reorder:
            notes.append(f"{self._way}: order is not kept, as the profile asks")
        else:
            numbers = [number for number, _, _ in self._came]
            overtaken = sum(later < earlier for earlier, later in pairwise(numbers))
            figures.append(expect.Figure("overtaken", 0.0, overtaken, 0.0))
        return figures

    def _delays(self, notes: list[str]) -> list[Figure]:
        """Judge the spaced packets; what a stall held, which the seed tells, is judged apart."""
        settings = self._settings
        rate_bps = settings.rate_bps
        base_ms = settings.delay_ms + (SMALL_BYTES * 8000 / rate_bps if rate_bps else 0.0)
        free_ms, held_ms, stalled_ms = [], [], []
        touched_s = 0.0
        for _, sent_s, came_s in self._came:
            if sent_s >= self._timetable.dense_s:
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
            own_ms = base_ms + jitter_quantile_ms(settings.jitter, 0.5)
            promised_ms = sum(held_ms) / len(held_ms)
            measured_ms = sum(stalled_ms) / len(stalled_ms) - own_ms
            figures.append(
                expect.time_figure("stall_ms", promised_ms, measured_ms, self._crowding_ms())
            )
        return figures

    def _rates(self, notes: list[str]) -> list[Figure]:
        settings = self._settings
        rate_bps = mean_bps(settings)
        if rate_bps is None or rate_bps > CARRIED_BPS:
            notes.append(
                f"{self._way}: the rate is above {CARRIED_BPS / 1e6:g} Mbit/s, so it is not filled"
            )
            return []
        size_bytes = full_bytes(rate_bps)
        guard_s = 0.1
        steps = settings.steps()
        ends_s = [at_s for at_s, _ in steps[1:]] + [max(FULL_S, CHANGE_EVERY_S * len(steps))]
        figures: list[Figure] = []
        for (at_s, conditions), end_s in zip(steps, ends_s, strict=True):
            # From when the queue's first packets have come, until its last ones have not yet.
            first_s = self._timetable.full_s + at_s + conditions.delay_ms / 1000 + guard_s
            last_s = self._timetable.full_s + end_s + conditions.delay_ms / 1000 - guard_s
            inside = [
                (came_s, size_bytes)
                for _, sent_s, came_s in self._came
                if sent_s >= self._timetable.full_s and first_s <= came_s < last_s
            ]
            promised = mean_bps(settings) if settings.trace else conditions.rate_bps
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
        full_s = self._timetable.full_s + FULL_S * 0.6
        waits_ms = [
            (came_s - sent_s) * 1000 for _, sent_s, came_s in self._came if sent_s >= full_s
        ]
        packet_ms = size_bytes * 8000 / rate_bps
        own_ms = settings.delay_ms + jitter_quantile_ms(settings.jitter, 0.5)
        measured_ms = expect.quantile(waits_ms, 0.5) - own_ms
        # A queue is full when one more packet does not fit, so it is up to one short of full.
        promised_ms = queue_s(settings) * 1000 - packet_ms / 2
        error_ms = packet_ms / 4 + self._crowding_ms()
        return expect.time_figure("queue_ms", promised_ms, measured_ms, error_ms)

    def _crowding_ms(self) -> float:
        """Return how uncertain the delay is of packets that come close together.

        They keep their order, so that each has the latest of their jitters.
        """
        jitter = self._settings.jitter
        return (jitter_quantile_ms(jitter, 0.98) - jitter_quantile_ms(jitter, 0.5)) / 2
