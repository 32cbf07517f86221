"""From raw series to figures, pure."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Literal, TypeVar

from e2e.delay.figures import Figures, Pauses
from e2e.delay.readings import Counters, OwnSound
from e2e.instrument.bursts import Burst, bursts, skews_ms
from e2e.instrument.pauses import concealed_pauses, tone_pauses
from e2e.instrument.quantities import drift_per_min, rate_per_s, summed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.readings import Pictures, Readings

C = TypeVar("C", Counters, OwnSound)


def figures(readings: Readings, *, settle_s: float = 3.0, to_ms: float | None = None) -> Figures:
    """Sum up one page from `settle_s` after its first picture to `to_ms`, else to its last row.

    Sound counts from `settle_s` after it was first heard, if that is later: its jitter buffer
    settles too. What there is nothing to sum up of is None. The lips are not judged here.
    """
    from_ms = begin_ms(readings) + 1000 * settle_s
    to_ms = max(from_ms, _last_ms(readings) if to_ms is None else to_ms)
    sound_from_ms = max(from_ms, (readings.first_sound_ms or 0.0) + 1000 * settle_s)

    ages = picture_ages(readings.pictures)
    aged = [(at, age) for at, age in ages if from_ms <= at <= to_ms]
    heard: list[Burst] = []
    if not _is_speech(readings.pictures):
        found = bursts(readings.sound, readings.heard_counters, ages)
        heard = [burst for burst in found if sound_from_ms <= burst.heard_ms <= to_ms]
    skews = skews_ms(heard, ages)
    absolute = summed([abs(skew) for skew in skews])
    counters = _within(readings.counters, from_ms, to_ms)
    shown = shown_ms(readings.pictures)
    return Figures(
        from_ms=from_ms,
        to_ms=to_ms,
        sound_from_ms=sound_from_ms,
        picture_age_ms=summed([age for _, age in aged]),
        sound_age_ms=summed([burst.age_ms for burst in heard]),
        skew_ms=summed(skews),
        absolute_skew_p95_ms=absolute.p95 if absolute else None,
        pictures_per_s=_pictures_per_s(shown, from_ms, to_ms),
        longest_freeze_ms=_longest_freeze_ms(shown, from_ms, to_ms),
        tone_pauses=Pauses()
        if _is_speech(readings.pictures)
        else tone_pauses(readings.sound, sound_from_ms, to_ms),
        concealed_pauses=concealed_pauses(readings.counters, sound_from_ms, to_ms),
        concealed_share=share(readings, "concealed", sound_from_ms, to_ms),
        stretched_share=share(readings, "stretched", sound_from_ms, to_ms),
        first_picture_ms=_after(readings.first_picture_ms, readings.opened_ms),
        command_round_trip_ms=summed(
            [
                trip_ms
                for at, trip_ms in zip(
                    readings.commands.at_ms, readings.commands.round_trip_ms, strict=True
                )
                if from_ms <= at <= to_ms
            ]
        ),
        received_bytes_per_s=rate_per_s(counters.at_ms, counters.received_bytes),
        received_audio_bytes_per_s=rate_per_s(counters.at_ms, counters.audio_bytes),
        received_video_bytes_per_s=rate_per_s(counters.at_ms, counters.video_bytes),
        sent_bytes_per_s=rate_per_s(counters.at_ms, counters.sent_bytes),
        picture_drift_ms_per_min=drift_per_min([at for at, _ in aged], [age for _, age in aged]),
        sound_drift_ms_per_min=drift_per_min(
            [burst.heard_ms for burst in heard], [burst.age_ms for burst in heard]
        ),
    )


def begin_ms(readings: Readings) -> float:
    """When there was something to judge: what settles is counted from here, Unix ms."""
    return readings.first_picture_ms or readings.first_sound_ms or readings.opened_ms


def _last_ms(readings: Readings) -> float:
    series = (
        readings.pictures.at_ms,
        readings.sound.start_ms,
        readings.counters.at_ms,
        readings.commands.at_ms,
    )
    return max((at_ms[-1] for at_ms in series if at_ms), default=readings.opened_ms)


def _after(moment_ms: float | None, opened_ms: float) -> float | None:
    return None if moment_ms is None else moment_ms - opened_ms


def _is_speech(pictures: Pictures) -> bool:
    """Tell speech from the test card: in a voice there are neither its tones nor its pauses."""
    has_mouth = any(mouth is not None for mouth in pictures.mouth)
    return has_mouth and all(stamp is None for stamp in pictures.stamp_ms)


def picture_ages(pictures: Pictures) -> list[tuple[float, float]]:
    """Moment and age of each presented picture whose stamp was read."""
    return [
        (at, at - stamp)
        for at, stamp in zip(pictures.at_ms, pictures.stamp_ms, strict=True)
        if stamp is not None
    ]


def shown_ms(pictures: Pictures) -> list[float]:
    """When the picture changed: the same stamp again is the same picture, shown again."""
    rows = list(zip(pictures.at_ms, pictures.stamp_ms, strict=True))
    again = [False] + [
        stamp is not None and stamp == old for (_, old), (_, stamp) in pairwise(rows)
    ]
    return [at for (at, _), same in zip(rows, again, strict=False) if not same]


def _pictures_per_s(shown: list[float], from_ms: float, to_ms: float) -> float | None:
    if not shown or to_ms <= from_ms:
        return None
    return 1000 * sum(from_ms <= at <= to_ms for at in shown) / (to_ms - from_ms)


def _longest_freeze_ms(shown: list[float], from_ms: float, to_ms: float) -> float | None:
    """Return the longest time without a change, cut to the window at both of its ends."""
    if not shown or to_ms <= from_ms:
        return None
    inside = [at for at in shown if from_ms <= at <= to_ms]
    edges = [from_ms, *inside, to_ms]
    return max(after - before for before, after in pairwise(edges))


def _within(columns: C, from_ms: float, to_ms: float) -> C:
    rows = [i for i, at in enumerate(columns.at_ms) if from_ms <= at <= to_ms]
    names = type(columns).model_fields
    return type(columns)(**{name: [getattr(columns, name)[i] for i in rows] for name in names})


def share(
    readings: Readings, what: Literal["concealed", "stretched"], from_ms: float, to_ms: float
) -> float | None:
    """Return how much of what was played was so, by the count of whichever player played."""
    own = _within(readings.own_sound, from_ms, to_ms)
    counters = _within(readings.counters, from_ms, to_ms)
    if own.at_ms:
        played = _risen(own.played_ms)
        found = _risen(own.made_up_ms if what == "concealed" else own.stretched_ms)
        return found / played if played else None
    all_per_s = rate_per_s(counters.at_ms, counters.played_samples)
    per_s = rate_per_s(counters.at_ms, getattr(counters, f"{what}_samples"))
    return per_s / all_per_s if all_per_s and per_s is not None else None


def _risen(counts: Sequence[float]) -> float:
    """Return by how much a count grew that begins at 0 again when the player does."""
    return sum(after - before if after >= before else after for before, after in pairwise(counts))
