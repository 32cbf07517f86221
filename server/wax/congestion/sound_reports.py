"""Loss of the sound from receiver reports alone (RFC 3550, 6.4.1). Pure."""

from __future__ import annotations

from collections import deque
from typing import Final

from wax.congestion.loss_based import LossBasedControl

_REPORTS: Final = 2
"""Loss is averaged over this many reports: about 10 s, as with transport-wide feedback. libwebrtc
sends one every 5 s. With one, 5 % loss is measured as 2.6 to 8.2 %, with two as 3.3 to 7.0. Ours.
"""
_MAX_USE_FACTOR: Final = 4.0
"""Without other feedback, the maximum multiple of the rate in use. As the estimator's."""


class SoundReports:
    """Takes each receiver report on the sound; times in seconds that never fall."""

    def __init__(self) -> None:
        self._lost: deque[float] = deque(maxlen=_REPORTS)
        self._control: LossBasedControl | None = None

    @property
    def lost(self) -> float | None:
        """The share lost lately, None without reports."""
        return sum(self._lost) / len(self._lost) if self._lost else None

    def add(self, lost: float) -> None:
        """Count a share from 0 to 1."""
        self._lost.append(lost)

    def rate_bps(self, used_bps: float, known_bps: float, now_s: float) -> float:
        """Return the rate after a report, while there is no other feedback.

        It follows the loss, starts at the rate in use, and is capped at the estimate of the start.
        """
        if self._control is None:
            start_bps = min(_MAX_USE_FACTOR * used_bps, known_bps)
            self._control = LossBasedControl(start_bps, known_bps)
        self._control.reported(self._lost[-1], now_s)
        return self._control.rate_bps

    def heard(self) -> None:
        """Stop controlling the rate: feedback has come, which shows more."""
        self._control = None
