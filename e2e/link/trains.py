"""What is sent to verify a profile, and when; pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from tests.link.chance import jitter_quantile_ms
from tests.link.trace import TraceTransmitter, read

from e2e.link.probe import Plan, Train

if TYPE_CHECKING:
    from tests.link.profile import DirectionSettings, Profile

CARRIED_BPS: Final = 25_000_000
"""A rate above it is not filled: the emulator is in Python."""

SMALL_BYTES: Final = 60
_SPACED_S: Final = 2.8
_DENSE_S: Final = 1.0
_DENSE_PPS: Final = 4000
FULL_S: Final = 2.2
CHANGE_EVERY_S: Final = 1.2
_STALL_EVERY_S: Final = 0.8
_OVERLOAD: Final = 1.25
_FILLING: Final = 3.0
"""At first so many times the rate, until the queue is full."""
_SETTLE_S: Final = 0.1

WayName = Literal["down", "up"]
WAYS: Final[tuple[WayName, WayName]] = ("down", "up")


@dataclass(frozen=True, slots=True)
class Timetable:
    """When the trains begin and when the changes do, monotonic."""

    spaced_s: float
    dense_s: float
    full_s: float
    end_s: float


def shortened(profile: Profile) -> Profile:
    """Bring stalls and changes into the time that there is."""
    ways: dict[str, DirectionSettings] = {}
    for way in WAYS:
        settings: DirectionSettings = getattr(profile, way)
        update: dict[str, object] = {}
        if settings.stalls is not None:
            every_s = min(settings.stalls.every_s, _STALL_EVERY_S)
            update["stalls"] = settings.stalls.model_copy(update={"every_s": every_s})
        if settings.changes:
            update["changes"] = [
                change.model_copy(update={"at_s": (index + 1) * CHANGE_EVERY_S})
                for index, change in enumerate(settings.changes)
            ]
        ways[way] = settings.model_copy(update=update)
    return profile.model_copy(update=ways)


def timetable_of(profile: Profile, begin_s: float) -> Timetable:
    slowest_s = max(_latest_s(profile.down), _latest_s(profile.up))
    changes = max(len(profile.down.changes), len(profile.up.changes))
    losses = max(profile.down.loss.mean, profile.up.loss.mean) > 0
    dense_s = begin_s + _SPACED_S + slowest_s
    full_s = dense_s + (_DENSE_S + slowest_s if losses else 0.0)
    full_for_s = (changes + 1) * CHANGE_EVERY_S if changes else FULL_S
    queues_s = max(queue_s(profile.down), queue_s(profile.up))
    return Timetable(begin_s, dense_s, full_s, full_s + full_for_s + slowest_s + queues_s)


def _latest_s(settings: DirectionSettings) -> float:
    """Return how late a packet can be that does not queue."""
    stall_ms = settings.stalls.at_most_ms if settings.stalls else 0.0
    jitter_ms = jitter_quantile_ms(settings.jitter, 1.0)
    return (settings.delay_ms + jitter_ms + stall_ms) / 1000 + _SETTLE_S


def mean_bps(settings: DirectionSettings) -> float | None:
    if settings.trace is not None:
        return TraceTransmitter(read(settings.trace), 0.0).mean_bps
    return settings.rate_bps


def queue_s(settings: DirectionSettings) -> float:
    rate_bps = mean_bps(settings)
    if rate_bps is None or rate_bps > CARRIED_BPS:
        return 0.0
    if settings.queue_ms is not None:
        return settings.queue_ms / 1000
    return (settings.queue_bytes or 0) * 8 / rate_bps


def _spacing_s(settings: DirectionSettings) -> float:
    """Return a distance at which jitter hardly makes a packet wait for the one before."""
    width_ms = jitter_quantile_ms(settings.jitter, 0.98) - jitter_quantile_ms(settings.jitter, 0.02)
    return min(max(width_ms, 10.0), 60.0) / 1000


def full_bytes(rate_bps: float) -> int:
    """Return a packet size of which enough come in the time."""
    return 1200 if rate_bps >= 500_000 else 300


def plan_of(settings: DirectionSettings, timetable: Timetable) -> Plan:
    spaced = Train(
        timetable.spaced_s, timetable.spaced_s + _SPACED_S, _spacing_s(settings), SMALL_BYTES
    )
    trains = [spaced]
    rate_bps = mean_bps(settings)
    if timetable.full_s > timetable.dense_s:
        fastest_pps = min(_DENSE_PPS, (rate_bps or CARRIED_BPS) / 2 / (SMALL_BYTES * 8))
        end_s = timetable.dense_s + _DENSE_S
        trains.append(Train(timetable.dense_s, end_s, 1 / fastest_pps, SMALL_BYTES))
    if rate_bps is not None and rate_bps <= CARRIED_BPS:
        size_bytes = full_bytes(rate_bps)
        interval_s = size_bytes * 8 / rate_bps
        filled_s = timetable.full_s + 1.1 * queue_s(settings) / (_FILLING - 1)
        end_s = timetable.full_s + max(FULL_S, CHANGE_EVERY_S * (len(settings.changes) + 1))
        trains.append(Train(timetable.full_s, filled_s, interval_s / _FILLING, size_bytes))
        trains.append(Train(filled_s, end_s, interval_s / _OVERLOAD, size_bytes))
    return Plan(trains, timetable.end_s)
