"""How a change of the link affects the picture: how long until it is fresh, good and full again."""

from __future__ import annotations

from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Final

from e2e.instrument.sums import pauses_ms, picture_ages, sized

if TYPE_CHECKING:
    from e2e.delay.readings import Readings
    from e2e.instrument.bursts import Series

STALL_MS: Final = 200.0
"""Two video MUs: at ten pictures a second, one is missing (after 5.3)."""
RECOVERED_MS: Final = 100.0
SILENCE_MS: Final = 1500.0
"""After a gap of this length, judgement restarts."""
FRESH_MS: Final = 300.0
FULL_RATE: Final = 27.0
"""Nine tenths of the 30 pictures a second that every system is configured for."""
HELD_MS: Final = 1000.0
_FULL: Final = (640, 480)


def after_changes(
    readings: Readings, worse_ms: float, whole_ms: float, end_ms: float
) -> dict[str, float | None]:
    """Return the figures; the link got worse and was whole again, and the cell ended, in Unix ms.

    None means never reached.
    """
    ages = picture_ages(readings.pictures)
    shown = sized(readings.pictures, _FULL)
    heard, counted = pauses_ms(readings, worse_ms, end_ms)
    return {
        "fresh_after_ms": fresh_after_ms(ages, worse_ms, end_ms),
        "step_pause_ms": max([0.0, *heard, *counted]),
        "full_after_ms": full_after_ms(shown, whole_ms),
        "picture_recovered_ms": recovery_ms(standing(ages), worse_ms, whole_ms),
    }


def standing(ages: Series) -> Series:
    """Before each late picture, insert the age that the previous one had reached by then."""
    found: Series = ages[:1]
    for (before_ms, before_age_ms), (at_ms, age_ms) in pairwise(ages):
        if at_ms - before_ms >= STALL_MS:
            found.append((at_ms, before_age_ms + at_ms - before_ms))
        found.append((at_ms, age_ms))
    return found


def recovery_ms(series: Series, began_ms: float, at_ms: float) -> float | None:
    """Return the time from `at_ms` until the age is as before the changes for a second.

    As before means at most `RECOVERED_MS` above the median before `began_ms`. None if that is never
    reached, or if there was nothing before.
    """
    before = [value for when_ms, value in series if when_ms < began_ms]
    if not before:
        return None
    limit_ms = median(before) + RECOVERED_MS
    since: float | None = None
    last_ms = at_ms
    for when_ms, value in series:
        if when_ms < at_ms:
            continue
        if value > limit_ms or when_ms - last_ms > SILENCE_MS:
            since = None
        if value <= limit_ms:
            since = when_ms if since is None else since
            if when_ms - since >= HELD_MS:
                return since - at_ms
        last_ms = when_ms
    return None


def fresh_after_ms(ages: Series, step_ms: float, end_ms: float) -> float | None:
    """Return the time from a step until the picture stays younger than `FRESH_MS` for 1 s.

    Between two pictures the older one ages. None if that is not reached before `end_ms`.
    """
    fresh_ms = step_ms
    last_ms = max([at_ms for at_ms, _ in ages if at_ms <= end_ms], default=step_ms)
    spans = [*pairwise(ages), *([(ages[-1], (end_ms, 0.0))] if ages else [])]
    for (at_ms, age_ms), (next_ms, _) in spans:
        stale_ms = at_ms + max(0.0, FRESH_MS - age_ms)
        if stale_ms >= next_ms or next_ms <= step_ms:
            continue
        if stale_ms - fresh_ms >= HELD_MS:
            break
        fresh_ms = next_ms
    return fresh_ms - step_ms if last_ms - fresh_ms >= HELD_MS else None


def full_after_ms(shown: list[tuple[float, bool]], from_ms: float) -> float | None:
    """Return the time until pictures are full size at the full rate for 1 s; None if never."""
    times = [at_ms for at_ms, _ in shown]
    for place, (at_ms, _) in enumerate(shown):
        if at_ms < from_ms or times[-1] < at_ms + HELD_MS:
            continue
        held = [large for when_ms, large in shown[place:] if when_ms < at_ms + HELD_MS]
        if all(held) and len(held) >= FULL_RATE:
            return at_ms - from_ms
    return None
