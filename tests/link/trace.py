"""Traces of packet delivery opportunities, in the format of mahimahi's ``mm-link``.

Each line is a time in whole ms at which 1500 bytes may leave; several lines may have the same time.
At its end, which is the time of the last line, the trace starts over.
"""

from __future__ import annotations

from bisect import bisect_left
from itertools import pairwise
from pathlib import Path
from typing import Final

from tests.link.errors import ProfileError

OPPORTUNITY_BYTES: Final = 1500


def read(path: str) -> list[int]:
    """Return the times of a trace file in ms. Raises `ProfileError`."""
    try:
        lines = Path(path).read_text(encoding="ascii").split()
        times_ms = [int(line) for line in lines]
    except OSError as error:
        raise ProfileError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ProfileError(f"{path}: is no trace: each line must be a time in ms") from error
    if not times_ms or times_ms[-1] <= 0 or times_ms[0] < 0:
        raise ProfileError(f"{path}: is no trace: it must last longer than 0 ms")
    if any(later < earlier for earlier, later in pairwise(times_ms)):
        raise ProfileError(f"{path}: is no trace: its times must not fall")
    return times_ms


class TraceTransmitter:
    """Sends packets, first in first out, at the opportunities of a trace.

    A packet may take several opportunities and several packets may share one; an unused opportunity
    is lost, as in mahimahi. `start` sets the trace to its beginning.
    """

    def __init__(self, times_ms: list[int], start_s: float) -> None:
        self._times_ms = times_ms
        self._zero_s = start_s
        self._index = 0
        self._left_bytes = OPPORTUNITY_BYTES

    @property
    def mean_bps(self) -> float:
        """The rate of the whole trace."""
        return len(self._times_ms) * OPPORTUNITY_BYTES * 8000 / self._times_ms[-1]

    def start(self, now_s: float) -> None:
        self._zero_s = now_s
        self._index, self._left_bytes = 0, OPPORTUNITY_BYTES

    def finish_s(self, begin_s: float, size_bytes: int) -> float:
        """Return when the last byte leaves of a packet that is first in the queue at `begin_s`."""
        self._skip_to(begin_s)
        while size_bytes > self._left_bytes:
            size_bytes -= self._left_bytes
            self._index, self._left_bytes = self._index + 1, OPPORTUNITY_BYTES
        self._left_bytes -= size_bytes
        return self._time_s(self._index)

    def _time_s(self, index: int) -> float:
        rounds, at = divmod(index, len(self._times_ms))
        return self._zero_s + (rounds * self._times_ms[-1] + self._times_ms[at]) / 1000

    def _skip_to(self, begin_s: float) -> None:
        """Skip the opportunities before `begin_s`; one at that very moment may still be used."""
        if self._time_s(self._index) >= begin_s:
            return
        rounds, at_ms = divmod((begin_s - self._zero_s) * 1000, self._times_ms[-1])
        self._index = int(rounds) * len(self._times_ms) + bisect_left(self._times_ms, at_ms)
        while self._time_s(self._index) < begin_s:  # rounding may leave it one short
            self._index += 1
        self._left_bytes = OPPORTUNITY_BYTES
