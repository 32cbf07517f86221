"""The master stream of one viewer, with one MU in flight and at most one waiting (thesis 3.3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.baseline.media_units import SourceSlot
from wax.baseline.transfer_time import TransferTime

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit
    from wax.baseline.transfer_time import LeastRoundTrip
    from wax.config.thesis import ThesisSettings


class MasterStream:
    """Queues one MU for at most an MU's length; then the next replaces it, or it is dropped."""

    def __init__(self, settings: ThesisSettings, round_trip: LeastRoundTrip) -> None:
        self._round_trip = round_trip
        self._transfer = TransferTime(round_trip, lost_after_s=settings.lost_after_ms / 1000)
        self._slot = SourceSlot(longest_wait_s=settings.audio_mu_ms / 1000)
        self._put_s: dict[int, float] = {}
        self._delay_s = 0.0

    def put(self, mu: MediaUnit, now_s: float) -> MediaUnit | None:
        """Queue an MU; return the one that it replaces."""
        self._put_s[mu.number] = now_s
        return self._skipped(self._slot.put(mu, now_s))

    def expire(self, now_s: float) -> MediaUnit | None:
        """Drop and return an MU that has waited longer than an MU length."""
        return self._skipped(self._slot.expire(now_s))

    def clear(self) -> MediaUnit | None:
        """Drop and return the waiting MU."""
        return self._skipped(self._slot.take())

    def pop(self, now_s: float) -> MediaUnit | None:
        """Return the MU to send now; None if there is none or one is still in flight."""
        if self._transfer.under_way is not None or (mu := self._slot.take()) is None:
            return None
        self._transfer.left(mu, now_s)
        return mu

    def acknowledged(self, number: int, now_s: float) -> None:
        """Allow the next MU to be sent, if this is the one in flight."""
        if (mu := self._transfer.acknowledged(number, now_s)) is not None:
            self._delay_s = self._since_put_s(self._put_s.pop(mu.number), now_s)

    def give_up(self, now_s: float) -> MediaUnit | None:
        """Return the MU in flight if it counts as lost; then the next may be sent."""
        if (mu := self._transfer.give_up(now_s)) is not None:
            self._delay_s = self._since_put_s(self._put_s.pop(mu.number), now_s)
        return mu

    def delay_s(self, now_s: float) -> float:
        """Return the end-to-end delay of the last MU, or more if one is already later.

        It counts from when the MU could have been sent until its arrival, which is half the least
        round trip before its acknowledgement.
        """
        oldest_s = min(self._put_s.values(), default=now_s)
        return max(self._delay_s, self._since_put_s(oldest_s, now_s))

    def forget_delay(self) -> None:
        """Forget the last MU's delay, so that only later ones count."""
        self._delay_s = 0.0

    def _since_put_s(self, put_s: float, now_s: float) -> float:
        return now_s - put_s - self._round_trip.seconds / 2

    def _skipped(self, mu: MediaUnit | None) -> MediaUnit | None:
        if mu is not None:
            del self._put_s[mu.number]
        return mu
