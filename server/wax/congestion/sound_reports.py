"""Sound of whose packets a browser tells nothing but how many it lost (RFC 3550, 6.4.1). Pure."""

from __future__ import annotations

from collections import deque
from typing import Final

from wax.congestion.loss_based import LossBasedControl

_REPORTS: Final = 2
"""The loss is averaged over so many reports: about 10 s, as where each packet is told of. libwebrtc
sends one each 5 s. Ours. Half: of 5 % between 2.6 and 8.2 % are told, with two 3.3 to 7.0; double:
a burst at the beginning is told for 20 s."""

_MAX_USE_FACTOR: Final = 4.0
"""Where nothing else is told the link carries no more than so many times what is in use. As the
estimator's. Half: on 24 kbit/s sound 265 ms → 488 ms; double: the same."""


class SoundReports:
    """Told of each receiver report on the sound; times in seconds that never fall."""

    def __init__(self) -> None:
        self._lost: deque[float] = deque(maxlen=_REPORTS)
        self._control: LossBasedControl | None = None

    @property
    def lost(self) -> float | None:
        """The share that was lost lately, None where nothing was reported."""
        return sum(self._lost) / len(self._lost) if self._lost else None

    def add(self, lost: float) -> None:
        """Count a share from 0 to 1."""
        self._lost.append(lost)

    def rate_bps(self, used_bps: float, known_bps: float, now_s: float) -> float:
        """Return the rate after a report, while nothing else is told.

        It follows the loss, from what is in use and to no more than was known when this began.
        """
        if self._control is None:
            start_bps = min(_MAX_USE_FACTOR * used_bps, known_bps)
            self._control = LossBasedControl(start_bps, known_bps)
        self._control.reported(self._lost[-1], now_s)
        return self._control.rate_bps

    def heard(self) -> None:
        """Leave the rate to what tells more: feedback has come."""
        self._control = None
