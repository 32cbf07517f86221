"""The round trip from receiver reports (RFC 3550, 6.4.1), of any length. Pure."""

from __future__ import annotations

from typing import Final

from wax.bounded_dict import BoundedDict

_KEPT: Final = 16
"""Sender reports to remember; at one a second a round trip may take that many seconds."""


class SenderReportTimes:
    """The times of the last sender reports: an answer to any of them gives a round trip.

    Remembering only the last one, as is common, fails on links whose round trip exceeds the report
    interval.
    """

    def __init__(self) -> None:
        self._sent_s = BoundedDict[int, float](_KEPT)

    def sent(self, ntp: int, now_s: float) -> None:
        """Record a sender report with this NTP time."""
        self._sent_s[ntp >> 16 & 0xFFFFFFFF] = now_s

    def round_trip_s(self, last_report: int, delay: int, now_s: float) -> float | None:
        """Return the round trip for LSR and DLSR (1/65536 s) of a report; None if unknown."""
        sent_s = self._sent_s.get(last_report)
        if sent_s is None:
            return None
        trip_s = now_s - sent_s - delay / 65536
        return trip_s if trip_s >= 0 else None
