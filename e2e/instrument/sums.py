"""From raw series to figures, pure."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, Literal, TypeVar

import numpy as np

from e2e.delay.readings import Counters, PlayerSound
from e2e.instrument.bursts import Series, bursts, skews_ms
from e2e.instrument.pauses import concealed_pauses, tone_pauses
from e2e.measure.row import summarize

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.readings import Pictures, Readings

C = TypeVar("C", Counters, PlayerSound)

SETTLE_S: Final = 3.0
BRIDGED_MS: Final = 50.0
"""The gap that 2004's client bridged: its delay of 38 ms was not heard, being shorter (5.2.1.3)."""
ENDED_MS: Final = 5000.0
"""Without a picture for this long at the end of a cell, the viewer is disconnected."""
_LEAST_SPAN_MS: Final = 5000.0
_LEAST_POINTS: Final = 5


@dataclass(frozen=True, slots=True)
class Window:
    """The time that counts, Unix ms; for sound it starts at `sound_from_ms`."""

    from_ms: float
    to_ms: float
    sound_from_ms: float

    @property
    def seconds(self) -> float:
        return (self.to_ms - self.from_ms) / 1000

    def has(self, at_ms: float) -> bool:
        return self.from_ms <= at_ms <= self.to_ms


def window(readings: Readings, *, settle_s: float = SETTLE_S, to_ms: float | None = None) -> Window:
    """Return the window from `settle_s` after the first picture to `to_ms`, or to the last row.

    Sound counts from `settle_s` after it was first heard, if that is later: its jitter buffer
    settles too.
    """
    begin_ms = readings.first_picture_ms or readings.first_sound_ms or readings.opened_ms
    from_ms = begin_ms + 1000 * settle_s
    to_ms = max(from_ms, _last_ms(readings) if to_ms is None else to_ms)
    sound_from_ms = max(from_ms, (readings.first_sound_ms or 0.0) + 1000 * settle_s)
    return Window(from_ms, to_ms, sound_from_ms)


def figures(readings: Readings, within: Window) -> dict[str, float]:
    """Sum up one page, by the names of `e2e.delay.measures`; figures without data are left out."""
    ages = picture_ages(readings.pictures)
    aged = [(at, age) for at, age in ages if within.has(at)]
    all_heard = sound_bursts(readings)
    heard = [(at, age) for at, age in all_heard if within.sound_from_ms <= at <= within.to_ms]
    shown = [at for at, _ in sized(readings.pictures, (0, 0))]
    counters = _within(readings.counters, within.from_ms, within.to_ms)
    commands = zip(readings.commands.at_ms, readings.commands.round_trip_ms, strict=True)
    first_ms, sounds_ms = readings.first_picture_ms, readings.first_sound_ms
    found: dict[str, float | None] = {
        **_quantiles("picture_age", [age for _, age in aged]),
        **_quantiles("arrival_age", _arrivals(readings.pictures, within)),
        **_quantiles("sound_age", [age for _, age in heard]),
        **_quantiles("command_round_trip", [trip for at, trip in commands if within.has(at)]),
        "skew_p50_ms": _median(skews_ms(heard, ages)),
        "joined_skew_p95_ms": _p95([abs(one) for one in _joined(readings, all_heard, within)]),
        "pictures_per_s": _rate(shown, within),
        "longest_freeze_ms": _longest_freeze_ms(shown, within),
        "first_picture_ms": None if first_ms is None else first_ms - readings.opened_ms,
        "picture_drift_ms_per_min": drift_per_min(aged),
        "sound_drift_ms_per_min": drift_per_min(heard),
        "breaks": _breaks(readings, within),
        "set_points_per_s": _rate(readings.set_points.at_ms, within),
    }
    for least in ((1280, 720), (640, 480), (160, 120)):
        times = [at for at, large in sized(readings.pictures, least) if large]
        name = f"pictures_{least[0]}_per_s"
        found[name] = (_rate(times, within) or 0.0) if shown and within.seconds > 0 else None
    if sounds_ms is not None:
        for what in ("concealed", "stretched"):
            part = share(readings, what, sounds_ms, within.to_ms)
            found[f"{what}_percent"] = None if part is None else 100 * part
        lengths_ms = pauses_ms(readings, sounds_ms, within.to_ms)
        found["pauses"] = float(max(map(len, lengths_ms)))
    for what in ("received", "sent"):
        per_s = _per_s(counters.at_ms, getattr(counters, f"{what}_bytes"))
        found[f"{what}_kb_per_s"] = None if per_s is None else per_s / 1000
    found |= _pauses_per_min(readings, within)
    return {name: value for name, value in found.items() if value is not None}


def picture_ages(pictures: Pictures) -> Series:
    """Moment and age of each presented picture whose stamp was read."""
    return [
        (at, at - stamp)
        for at, stamp in zip(pictures.at_ms, pictures.stamp_ms, strict=True)
        if stamp is not None
    ]


def _arrivals(pictures: Pictures, within: Window) -> list[float]:
    """Return the ages of the pictures when their last packets had come."""
    rows = zip(pictures.at_ms, pictures.received_ms, pictures.stamp_ms, strict=True)
    return [
        received - stamp
        for at, received, stamp in rows
        if received is not None and stamp is not None and within.has(at)
    ]


def sound_bursts(readings: Readings) -> Series:
    """Return when each second's burst began to be heard, and its age."""
    # The browser does not count what the built-in player plays.
    counters = Counters() if readings.player_sound.at_ms else readings.counters
    return bursts(readings.sound, counters, picture_ages(readings.pictures))


def sized(pictures: Pictures, least: tuple[int, int]) -> list[tuple[float, bool]]:
    """Return when each new picture was shown, and whether it had at least this width and height.

    The same stamp again is the same picture, shown again.
    """
    found: list[tuple[float, bool]] = []
    before = None
    for at_ms, stamp_ms, width, height in zip(
        pictures.at_ms, pictures.stamp_ms, pictures.width, pictures.height, strict=True
    ):
        if stamp_ms is None or stamp_ms != before:
            found.append((at_ms, width >= least[0] and height >= least[1]))
        before = stamp_ms
    return found


def pauses_ms(readings: Readings, from_ms: float, to_ms: float) -> tuple[list[float], list[float]]:
    """Lengths of the gaps in the tone as heard, and of the concealments as counted."""
    heard = tone_pauses(readings.sound, from_ms, to_ms)
    counted = concealed_pauses(readings.counters, from_ms, to_ms)
    return [length_ms for _, length_ms in heard], [length_ms for _, length_ms in counted]


def share(
    readings: Readings, what: Literal["concealed", "stretched"], from_ms: float, to_ms: float
) -> float | None:
    """Return this share of what was played, by the counts of whichever player played."""
    player = _within(readings.player_sound, from_ms, to_ms)
    counters = _within(readings.counters, from_ms, to_ms)
    if player.at_ms:
        played = _risen(player.played_ms)
        found = _risen(getattr(player, f"{what}_ms"))
        return found / played if played else None
    all_per_s = _per_s(counters.at_ms, counters.played_samples)
    per_s = _per_s(counters.at_ms, getattr(counters, f"{what}_samples"))
    return per_s / all_per_s if all_per_s and per_s is not None else None


def drift_per_min(series: Series) -> float | None:
    """Return the robust slope (Theil–Sen) of the values over time, per minute.

    It uses the median of each second, so that every second counts the same. None over less than 5 s
    or 5 such seconds.
    """
    seconds: dict[int, Series] = {}
    for at, value in series:
        seconds.setdefault(math.floor(at / 1000), []).append((at, value))
    if len(seconds) < _LEAST_POINTS:
        return None
    points = [
        (statistics.median(at for at, _ in rows), statistics.median(value for _, value in rows))
        for _, rows in sorted(seconds.items())
    ]
    if points[-1][0] - points[0][0] < _LEAST_SPAN_MS:
        return None
    times, medians = np.array(points).T
    first, second = np.triu_indices(len(times), k=1)
    slopes = (medians[second] - medians[first]) / (times[second] - times[first])
    return float(np.median(slopes)) * 60_000


def _quantiles(name: str, values: Sequence[float]) -> dict[str, float | None]:
    return {f"{name}_p50_ms": _median(values), f"{name}_p95_ms": _p95(values)}


def _median(values: Sequence[float]) -> float | None:
    return statistics.median(values) if values else None


def _p95(values: Sequence[float]) -> float | None:
    return summarize(values).p95 if values else None


def _last_ms(readings: Readings) -> float:
    series = (
        readings.pictures.at_ms,
        readings.sound.start_ms,
        readings.counters.at_ms,
        readings.commands.at_ms,
    )
    return max((at_ms[-1] for at_ms in series if at_ms), default=readings.opened_ms)


def _joined(readings: Readings, heard: Series, within: Window) -> list[float]:
    """Return the skews from 3 s after joining, which is the first picture.

    Sound that comes later than that has no skew before; the figure of the first sound shows it.
    """
    if readings.first_picture_ms is None:
        return []
    from_ms = readings.first_picture_ms + 1000 * SETTLE_S
    counted = [(at, age) for at, age in heard if from_ms <= at <= within.to_ms]
    return skews_ms(counted, picture_ages(readings.pictures))


def _rate(at_ms: Sequence[float], within: Window) -> float | None:
    if not at_ms or within.seconds <= 0:
        return None
    return sum(map(within.has, at_ms)) / within.seconds


def _longest_freeze_ms(shown: list[float], within: Window) -> float | None:
    """Return the longest time without a change, cut to the window at both of its ends."""
    if not shown or within.seconds <= 0:
        return None
    edges = [within.from_ms, *filter(within.has, shown), within.to_ms]
    return max(after - before for before, after in pairwise(edges))


def _breaks(readings: Readings, within: Window) -> float | None:
    """Return how often the page's connection changed its state after it was connected.

    An end without pictures counts as one. None if the state was not read.
    """
    states, shown = readings.connections.state, readings.pictures.at_ms
    if "connected" not in states:
        return None
    is_over = not shown or within.to_ms - shown[-1] > ENDED_MS
    return float(len(states) - 1 - states.index("connected") + is_over)


def _pauses_per_min(readings: Readings, within: Window) -> dict[str, float | None]:
    """Return the pauses a minute that 2004's client would not bridge, and the longest."""
    minutes = (within.to_ms - within.sound_from_ms) / 60_000
    if not readings.sound.start_ms or minutes <= 0:
        return {}
    heard, counted = pauses_ms(readings, within.sound_from_ms, within.to_ms)
    audible = max(sum(one > BRIDGED_MS for one in heard), len(counted))
    longest = max([0.0, *heard, *counted])
    return {"pauses_per_min": audible / minutes, "longest_pause_ms": longest}


def _per_s(at_ms: Sequence[float], counts: Sequence[float | None]) -> float | None:
    """Return how fast a count grew from the first to the last look that contains it."""
    known = [(at, count) for at, count in zip(at_ms, counts, strict=True) if count is not None]
    if len(known) < 2 or known[-1][0] <= known[0][0]:
        return None
    return 1000 * (known[-1][1] - known[0][1]) / (known[-1][0] - known[0][0])


def _risen(counts: Sequence[float]) -> float:
    """Return by how much a count grew that restarts at 0 whenever the player does."""
    return sum(after - before if after >= before else after for before, after in pairwise(counts))


def _within(columns: C, from_ms: float, to_ms: float) -> C:
    rows = [i for i, at in enumerate(columns.at_ms) if from_ms <= at <= to_ms]
    names = type(columns).model_fields
    return type(columns)(**{name: [getattr(columns, name)[i] for i in rows] for name in names})
