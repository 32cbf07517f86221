"""Chooses the packets that request transport-wide feedback: all, or a sample. Pure.

A packet without a transport-wide sequence number gets none
(draft-holmer-rmcat-transport-wide-cc-extensions-01). Each feedback packet costs the browser's
uplink about 75 bytes, up to twenty times a second (a tenth of a modem line), and the server as much
as sending four packets; a hundred settled observers need neither.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.delivery import LinkEstimate

_WINDOW_S: Final = 0.03
"""Length of a sample: a picture and the sound beside it."""
_SETTLED_EVERY_S: Final = 0.4
"""Interval of samples on a settled link: two of them find a queue."""
_THIN_EVERY_S: Final = 0.5
"""Interval on a thin link, of which feedback takes a part."""
_THIN_BPS: Final = 150_000.0
"""A link below this rate is thin, and only sampled, for full feedback would take 8 % of an equally
thin uplink."""
_SETTLED_QUEUE_MS: Final = 30.0
"""Longest queue of a settled link: the threshold of a standing queue."""
_SPARE_FACTOR: Final = 1.5
"""A settled link carries this multiple of the rate in use."""
_SOUND_EVERY_FACTOR: Final = 2.0
"""Sound begins a sample only if no picture did for this multiple of the interval."""


class FeedbackSampling:
    """Opens sample windows; a picture that begins in one is marked to its end."""

    def __init__(self) -> None:
        self._every_s = 0.0
        self._opened_s = float("-inf")
        self._train: tuple[int, bool] | None = None

    @property
    def is_sparse(self) -> bool:
        """Whether only samples are marked, so that feedback may take long."""
        return self._every_s > 0

    def follow(self, estimate: LinkEstimate, *, full_feedback: bool) -> None:
        """Choose the interval for this link; with `full_feedback`, only a thin link is sampled."""
        is_settled = (
            estimate.queue_ms < _SETTLED_QUEUE_MS
            and estimate.rate_bps > _SPARE_FACTOR * estimate.used_bps
        )
        if estimate.state != "steady":
            self._every_s = 0.0  # the fate of every packet must be known
        elif estimate.rate_bps < _THIN_BPS:
            self._every_s = _THIN_EVERY_S
        else:
            self._every_s = _SETTLED_EVERY_S if is_settled and not full_feedback else 0.0

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        """Return whether to mark a packet of this picture, or of sound (None)."""
        if train is not None and self._train is not None and train == self._train[0]:
            return self._train[1]
        # Pictures probe the link; sound opens a window only if there are none.
        every_s = self._every_s if train is not None else _SOUND_EVERY_FACTOR * self._every_s
        if now_s - self._opened_s >= every_s:
            self._opened_s = now_s
        is_open = self._every_s == 0.0 or now_s - self._opened_s < _WINDOW_S
        if train is not None:
            self._train = (train, is_open)
        return is_open
