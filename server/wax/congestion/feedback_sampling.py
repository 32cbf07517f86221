"""For which packets a browser shall send transport-wide feedback: all, or a sample.

A packet without a transport-wide sequence number is not told of
(draft-holmer-rmcat-transport-wide-cc-extensions-01). Each feedback costs the browser's uplink about
75 bytes, up to twenty times a second (a tenth of a modem line), and the server as much as sending
four packets; a hundred settled observers need neither. Pure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.delivery import LinkEstimate

_WINDOW_S: Final = 0.03
"""A sample lasts so long: a picture and the sound beside it. Ours.
Half: no change to speak of; double: route: use 89 % → 32 %."""

_SETTLED_EVERY_S: Final = 0.4
"""A settled link is sampled so often: a queue is found in two samples. Ours.
Half: long-outage: use 34 % → 48 %; double: long-outage: recovery 8.0 s → 1.0 s."""

_THIN_EVERY_S: Final = 0.5
"""A thin one so often, as feedback takes a part of it. Ours.
Half: no change to speak of; double: outages: recovery 23.0 s → 17.6 s."""

_THIN_BPS: Final = 150_000.0
"""Below this rate a link is thin: feedback for all would take 8 % of as thin an uplink. Ours.
Half: no change to speak of; double: cellular: concealed 2.3 % → 5.8 %."""

_SETTLED_QUEUE_MS: Final = 30.0
"""A settled link has no longer queue: what a standing queue begins with.
Half: route: picture 137 ms → 255 ms; double: the same."""

_SPARE_FACTOR: Final = 1.5
"""A settled link carries so many times what is sent over it. Ours.
Half: the same; double: long-outage: use 34 % → 51 %."""

_SOUND_EVERY_FACTOR: Final = 2.0
"""Sound begins a sample only where no picture did for so many times as long. Ours.
Half: long-outage: recovery 8.0 s → 1.0 s; double: the same."""


class FeedbackSampling:
    """Opens a window now and then; a picture that begins in one is marked to its end."""

    def __init__(self) -> None:
        self._every_s = 0.0
        self._opened_s = float("-inf")
        self._train: tuple[int, bool] | None = None

    @property
    def is_sparse(self) -> bool:
        """Whether only samples are marked, so that answers may be long in coming."""
        return self._every_s > 0

    def follow(self, estimate: LinkEstimate, *, full_feedback: bool) -> None:
        """Learn how the link is; a `full_feedback` one is settled only where it is thin."""
        if estimate.state != "steady":
            self._every_s = 0.0  # how much comes through must be known to the packet
        elif estimate.rate_bps < _THIN_BPS:
            self._every_s = _THIN_EVERY_S
        elif (
            not full_feedback
            and estimate.queue_ms < _SETTLED_QUEUE_MS
            and estimate.rate_bps > _SPARE_FACTOR * estimate.used_bps
        ):
            self._every_s = _SETTLED_EVERY_S
        else:
            self._every_s = 0.0

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        """Tell whether to mark a packet of this picture, or of sound (None)."""
        if train is not None and self._train is not None and train == self._train[0]:
            return self._train[1]
        # Pictures are what probes a link; sound opens a window only where none come.
        every_s = self._every_s if train is not None else _SOUND_EVERY_FACTOR * self._every_s
        if now_s - self._opened_s >= every_s:
            self._opened_s = now_s
        is_open = self._every_s == 0.0 or now_s - self._opened_s < _WINDOW_S
        if train is not None:
            self._train = (train, is_open)
        return is_open
