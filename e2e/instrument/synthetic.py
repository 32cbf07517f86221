"""Readings made up for the tests of the sums: a perfect page, and the requested flaws."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

from e2e.delay.readings import Counters, Pictures, Readings, Sound
from e2e.instrument.cards import lies

OPENED_MS = 1_800_000_000_000.0
ARRIVED_BEFORE_MS = 30.0
"""How long before it is presented a picture has arrived."""


def readings(
    seconds: float,
    *,
    picture_age_ms: float = 80.0,
    sound_age_ms: float = 120.0,
    lie_ms: float = 0.0,
    sound: bool = True,
) -> Readings:
    """Make 25 pictures and 100 blocks a second from the opening on; the clock may lie."""
    return Readings(
        opened_ms=OPENED_MS,
        first_picture_ms=OPENED_MS,
        first_sound_ms=OPENED_MS if sound else None,
        pictures=pictures(seconds, picture_age_ms, lie_ms),
        sound=blocks(seconds, sound_age_ms, lie_ms) if sound else Sound(),
    )


def pictures(seconds: float, age_ms: float, lie_ms: float = 0.0) -> Pictures:
    count = round(25 * seconds)
    at_ms = [OPENED_MS + 40 * n for n in range(count)]
    true_ms = [at - age_ms for at in at_ms]
    return Pictures(
        at_ms=at_ms,
        stamp_ms=[true - (lie_ms if lies(true) else 0) for true in true_ms],
        received_ms=[at - ARRIVED_BEFORE_MS for at in at_ms],
        width=[640] * count,
        height=[480] * count,
    )


def shown(*parts: tuple[float, float, float, int]) -> Pictures:
    """Make pictures in parts, each until a time (s), with pictures a second, age (ms) and width."""
    found, begin_s = Pictures(), 0.0
    for until_s, rate, age_ms, width in parts:
        for number in range(round((until_s - begin_s) * rate)):
            at_ms = OPENED_MS + 1000 * (begin_s + number / rate)
            found.at_ms.append(at_ms)
            found.stamp_ms.append(at_ms - age_ms)
            found.received_ms.append(None)
            found.width.append(width)
            found.height.append(width * 3 // 4)
        begin_s = until_s
    return found


def blocks(seconds: float, age_ms: float, lie_ms: float = 0.0) -> Sound:
    """Make the tone, and a burst at each whole second of the source's clock, in blocks of 10 ms."""
    count = round(100 * seconds)
    start_ms = [OPENED_MS + 10 * n for n in range(count)]
    burst = [0.4 * _share(at - age_ms, lie_ms) for at in start_ms]
    return Sound(start_ms=start_ms, tone=[0.05] * count, burst=burst)


def _share(true_ms: float, lie_ms: float) -> float:
    """Return which share of the 10 ms from this moment of capture is burst."""
    begin_ms: float = 1000 * round((true_ms - 45) / 1000)
    begin_ms += lie_ms if lies(begin_ms) else 0
    return max(0.0, min(true_ms + 10, begin_ms + 100) - max(true_ms, begin_ms)) / 10


def counters(concealed: list[tuple[float, int]], *, rate_hz: int = 48_000) -> Counters:
    """Make looks every 100 ms: what was concealed since the previous one, in ms and in events."""
    rows, later = range(len(concealed)), concealed[1:]
    columns: dict[str, list[Any]] = {name: [None for _ in rows] for name in Counters.model_fields}
    columns |= {
        "at_ms": [OPENED_MS + 100 * n for n in rows],
        "played_samples": [n * rate_hz / 10 for n in rows],
        "concealed_samples": list(accumulate((0.0, *(ms * rate_hz / 1000 for ms, _ in later)))),
        "concealment_events": list(accumulate((0.0, *(float(more) for _, more in later)))),
    }
    return Counters(**columns)
