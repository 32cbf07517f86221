"""Interruptions of the sound: as heard in the test card's tone, and as the browser counts them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from e2e.measure.ear import BLOCK_MS

if TYPE_CHECKING:
    from e2e.delay.readings import Counters, Sound

TONE_PAUSE_MS: Final = 30.0
CONCEALED_PAUSE_MS: Final = 100.0

_QUIET_TONE: Final = 0.0125
_QUIET_BURST: Final = 0.1
"""Both are a quarter, 12 dB, below what the card sends."""

_MISSING_MS: Final = 5.0
"""If the distance of two blocks exceeds their length by more than this, there is a gap."""

_END_MS: Final = 200.0
"""The last blocks may still be in flight to the reader: less than this is no pause at the end."""

_NEARLY_ALL: Final = 0.9
_RATES_HZ: Final = (8000, 16_000, 32_000, 48_000)


Pauses = list[tuple[float, float]]
"""Interruptions in the order in which they came: Unix time of the start, and length, ms."""


def tone_pauses(sound: Sound, from_ms: float, to_ms: float) -> Pauses:
    """Return gaps of 30 ms or more in the tone, cut to `from_ms` … `to_ms`.

    A block without tone and without burst is quiet; time without any block is quiet too, since
    nothing was played in it. Known to ± one block.
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
    """Return contiguous concealment of 100 ms or more that began from `from_ms` to `to_ms`.

    A concealment begins in a look in which the count of events rises, and continues through all
    looks in which concealed samples grow and that count does not: nothing else was played in
    between. It also continues through a look of which nine tenths were concealed, since its events
    are only a packet apart. If several begin in one look, its concealed samples are shared among
    them evenly. Residual error: the end of one that lies in the look in which another begins counts
    towards the other.
    """
    found: Pauses = []
    begin_ms, length_ms = 0.0, 0.0

    def close() -> None:
        if length_ms >= CONCEALED_PAUSE_MS and from_ms <= begin_ms <= to_ms:
            found.append((begin_ms, length_ms))

    for at_ms, played_ms, concealed_ms, events in _looks(counters):
        goes_on = length_ms > 0 and concealed_ms >= _NEARLY_ALL * played_ms
        if concealed_ms > 0 and (events == 0 or goes_on):
            if length_ms == 0:
                begin_ms = at_ms - concealed_ms
            length_ms += concealed_ms
            continue
        close()
        length_ms = 0.0
        for number in range(events):
            length_ms = concealed_ms / events
            begin_ms = at_ms - length_ms
            if number < events - 1:
                close()
    close()
    return found


def _looks(counters: Counters) -> list[tuple[float, float, float, int]]:
    """Return the time of each look, ms played and concealed since the previous one, and events."""
    counts = (counters.played_samples, counters.concealed_samples, counters.concealment_events)
    looks = zip(counters.at_ms, *counts, strict=True)
    rows = np.array([look for look in looks if None not in look], float).reshape(-1, 4)
    passed_ms, played, concealed, events = np.diff(rows, axis=0).T
    # The number of samples in a second depends on the codec.
    counted = (played > 0) & (passed_ms > 0)
    if not counted.any():
        return []
    measured_hz = np.median(1000 * played[counted] / passed_ms[counted])
    rate_hz = min(_RATES_HZ, key=lambda rate_hz: abs(rate_hz - measured_hz))
    lengths_ms = np.maximum(0.0, 1000 * np.array((played, concealed)) / rate_hz)
    begun = np.maximum(0, events.round()).astype(int)
    return list(zip(rows[1:, 0].tolist(), *lengths_ms.tolist(), begun.tolist(), strict=True))
