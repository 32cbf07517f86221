"""Interruptions of the sound: as heard in the test card's tone, and as the browser counts them."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from e2e.measure.ear import BLOCK_MS

if TYPE_CHECKING:
    from e2e.delay.readings import Counters, Sound

TONE_PAUSE_MS: Final = 30.0
CONCEALED_PAUSE_MS: Final = 100.0

_QUIET_TONE: Final = 0.0125
_QUIET_BURST: Final = 0.1
"""Both a quarter, 12 dB, below what the card sends."""

_MISSING_MS: Final = 5.0
"""Blocks that are farther apart than their length by more than this have a gap between them."""

_END_MS: Final = 200.0
"""The last blocks may be on their way to the reader: less than this is no pause at the end."""

_NEARLY_ALL: Final = 0.9
_RATES_HZ: Final = (8000, 16_000, 32_000, 48_000)


Pauses = list[tuple[float, float]]
"""Interruptions in the order in which they came: Unix time of the begin and length, ms."""


def tone_pauses(sound: Sound, from_ms: float, to_ms: float) -> Pauses:
    """Gaps of 30 ms or more in the tone, as far as they lie from `from_ms` to `to_ms`.

    Quiet is a block without tone and without burst; time of which there is no block is quiet too,
    since nothing was played in it. Known to ± one block.
    """
    found: Pauses = []
    quiet_ms: float | None = None  # since when
    end_ms: float | None = None
    for start_ms, tone, burst in zip(sound.start_ms, sound.tone, sound.burst, strict=True):
        if end_ms is not None and start_ms - end_ms > _MISSING_MS and quiet_ms is None:
            quiet_ms = end_ms
        if tone < _QUIET_TONE and burst < _QUIET_BURST:
            quiet_ms = start_ms if quiet_ms is None else quiet_ms
        elif quiet_ms is not None:
            _add(found, max(quiet_ms, from_ms), min(start_ms, to_ms))
            quiet_ms = None
        end_ms = start_ms + BLOCK_MS
    if end_ms is not None and quiet_ms is None and to_ms - end_ms > _END_MS:
        quiet_ms = end_ms
    if quiet_ms is not None:
        _add(found, max(quiet_ms, from_ms), to_ms)
    return found


def _add(pauses: Pauses, begin_ms: float, end_ms: float) -> None:
    # Half a block of tolerance: block times are measured, not multiples of 10.
    if end_ms - begin_ms >= TONE_PAUSE_MS - BLOCK_MS / 2:
        pauses.append((begin_ms, end_ms - begin_ms))


def concealed_pauses(counters: Counters, from_ms: float, to_ms: float) -> Pauses:
    """Contiguous concealment of 100 ms or more that began from `from_ms` to `to_ms`.

    A concealment goes from the look in which the count of events rises through all looks in which
    concealed samples grow while it does not: nothing else was played in between. It also goes
    through a look that was concealed for nine tenths, whose events are but a packet apart. Where
    several begin in one look, its concealed samples are shared among them evenly. Residual error:
    the end of one that lies in the look in which another begins is counted to the other.
    """
    found: Pauses = []
    begin_ms, length_ms = 0.0, 0.0

    def close() -> None:
        if length_ms >= CONCEALED_PAUSE_MS and from_ms <= begin_ms <= to_ms:
            found.append((begin_ms, length_ms))

    for look in _looks(counters):
        goes_on = length_ms > 0 and look.concealed_ms >= _NEARLY_ALL * look.played_ms
        if look.concealed_ms > 0 and (look.events == 0 or goes_on):
            if length_ms == 0:
                begin_ms = look.at_ms - look.concealed_ms
            length_ms += look.concealed_ms
            continue
        close()
        length_ms = 0.0
        for number in range(look.events):
            length_ms = look.concealed_ms / look.events
            begin_ms = look.at_ms - length_ms
            if number < look.events - 1:
                close()
    close()
    return found


@dataclass(frozen=True, slots=True)
class _Look:
    """What was counted since the look before."""

    at_ms: float
    played_ms: float
    concealed_ms: float
    events: int


def _looks(counters: Counters) -> list[_Look]:
    rows = [
        (at_ms, played, concealed, events)
        for at_ms, played, concealed, events in zip(
            counters.at_ms,
            counters.played_samples,
            counters.concealed_samples,
            counters.concealment_events,
            strict=True,
        )
        if played is not None and concealed is not None and events is not None
    ]
    # What one second of sound counts depends on its codec.
    rates = [
        1000 * (new[1] - old[1]) / (new[0] - old[0])
        for old, new in pairwise(rows)
        if new[1] > old[1] and new[0] > old[0]
    ]
    if not rates:
        return []
    measured_hz = statistics.median(rates)
    rate_hz = min(_RATES_HZ, key=lambda rate_hz: abs(rate_hz - measured_hz))
    return [
        _Look(
            at_ms=new[0],
            played_ms=max(0.0, 1000 * (new[1] - old[1]) / rate_hz),
            concealed_ms=max(0.0, 1000 * (new[2] - old[2]) / rate_hz),
            events=max(0, round(new[3] - old[3])),
        )
        for old, new in pairwise(rows)
    ]
