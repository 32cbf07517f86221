"""Congestion control at the sender, for everything sent to one browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.congestion.control import CongestionControl
from wax.congestion.estimator import LinkEstimator
from wax.congestion.feedback import FeedbackSampling
from wax.congestion.pacer import STARTING_RATE_BPS, Pacer
from wax.congestion.queuing_delay import PACKET_BITS
from wax.congestion.upload_budget import UploadBudget
from wax.congestion.wire_cost import TCP_IP_BYTES, payload_bytes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.congestion.control import Delivery, Kind, LinkEstimate, Train

_SETTLED_UPDATE_S: Final = 0.5
"""Interval of updates on a settled link, which is only sampled."""
_OTHER_S: Final = 2.0
"""The rate of the data channels is averaged over this time."""
_RETRANSMISSION_SHARE: Final = 0.25
"""Share for retransmissions, of the rate and of the original packets: a link that loses more needs
a smaller picture, and a viewer who requests every packet again costs only a quarter more."""
_RETRANSMISSION_BURST_S: Final = 0.25
"""Burst of retransmissions, in seconds of that share."""
_STALE_S: Final = 0.5
"""A packet first sent longer ago than this plus a round trip is useless."""
_FULL_QUEUE_MS: Final = 150.0
"""Behind a longer queue nothing is retransmitted: it would only grow."""
_FEEDBACK_S: Final = 0.1
"""Feedback arrives within this plus a round trip (Chromium: 50 ms). Without feedback, the estimate
is updated at this interval."""
_PROBE_EVERY_S: Final = 0.3
"""While feedback is missing, one picture is sent per interval, to test whether the link is back."""
_MOST_FILE_WAIT_S: Final = 5.0
"""The longest wait of a file's piece, however many others are queued."""
_FILE_SHARE: Final = 0.25
"""Share of the rate for files: unpaced TCP would fill the link's queue and delay the sound."""
_RETRY_S: Final = 0.02
"""Longest wait before checking again. Ours: less than a picture's interval."""


class SenderSideControl(CongestionControl):
    """Joins estimator, pacer and sampling; `on_news` is called when allocations may change."""

    uses_feedback = True

    def __init__(
        self,
        on_news: Callable[[LinkEstimate, float], None],
        budget: UploadBudget | None = None,
    ) -> None:
        self.full_feedback = False
        """Whether to request all feedback and retransmit beyond the budget, as for the operator."""
        self._on_news = on_news
        self._budget = UploadBudget(0) if budget is None else budget
        self._has_feedback: dict[Kind, bool] = {}
        self.reset()
        self._is_another_link = False

    def reset(self) -> None:
        """Forget everything about the link, because the viewer has moved to another one."""
        self._sampling = FeedbackSampling()
        self._trained_s = float("-inf")
        self._is_another_link = True
        self._estimator = LinkEstimator()
        self._pacer = Pacer(STARTING_RATE_BPS)
        self._updated_s = float("-inf")
        self.other_bps = 0.0
        """The rate of everything but sound and picture: data channels and acknowledgements."""
        self._other_s = float("-inf")
        self._files_s = float("-inf")
        self._retransmitted_bits = 0.0
        self._retransmitted_s = float("-inf")
        self._earned_bits = 0.0
        """Bits that original packets have earned for retransmissions; at most a burst is kept."""
        self._estimate: LinkEstimate | None = None
        for kind, has_feedback in self._has_feedback.items():
            self._estimator.negotiated(has_feedback=has_feedback, kind=kind)

    def estimate(self, now_s: float) -> LinkEstimate:
        self._estimate = self._estimator.estimate(now_s)
        return self._estimate

    def try_more(self, now_s: float) -> None:
        """Raise the rate for a picture that is tried again; call it once, when the trial begins."""
        self._estimator.try_more(now_s)
        self._pacer.rate_bps = self.estimate(now_s).rate_bps
        self._pacer.forgive()

    def negotiated(self, *, has_feedback: bool, kind: Kind = "video") -> None:
        self._has_feedback[kind] = has_feedback or self._has_feedback.get(kind, False)
        self._estimator.negotiated(has_feedback=has_feedback, kind=kind)

    def lost(self, share: float, now_s: float, kind: Kind = "video") -> None:
        self._estimator.reported(share, now_s, kind)

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        self._estimator.sent(size_bytes, now_s, has_feedback=has_feedback)
        self._pacer.spend(size_bytes, now_s)
        if is_media:
            self._earned_bits += _RETRANSMISSION_SHARE * 8 * size_bytes
        else:
            # A decaying average: each datagram adds its share of the window.
            elapsed_s, self._other_s = max(now_s - self._other_s, 0.0), now_s
            self.other_bps *= max(1.0 - elapsed_s / _OTHER_S, 0.0)
            self.other_bps += 8 * size_bytes / _OTHER_S
        every_s = _SETTLED_UPDATE_S if self._sampling.is_sparse else _FEEDBACK_S
        if now_s - self._updated_s >= every_s:
            self._update(now_s)

    def file_sent(self, size_bytes: int, now_s: float) -> float:
        """Count a file's piece that is sent now; return how long the next one must wait, in s.

        It waits until the link has drained everything sent before it.
        """
        size_bytes += TCP_IP_BYTES
        self._estimator.sent(size_bytes, now_s, has_feedback=False)
        self._pacer.spend(size_bytes, now_s)
        took_s = 8 * size_bytes / (_FILE_SHARE * self._pacer.rate_bps)
        free_s = max(self._files_s, now_s) + took_s
        self._files_s = min(free_s, now_s + _MOST_FILE_WAIT_S)
        return min(max(self._files_s - now_s, self._pacer.free_in_s(now_s)), _MOST_FILE_WAIT_S)

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        self._estimator.delivered(deliveries, now_s)
        if now_s != self._updated_s:  # once for all the feedback in one datagram
            self._update(now_s)

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        self._estimator.round_trip(round_trip_s, now_s)

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        return self._sampling.requests_feedback(train, now_s)

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:
        if self._is_another_link:
            return 0.0  # only its first picture tells what it carries
        wait_s = self._pacer.free_in_s(now_s)
        if self._is_stuck(unreported_s):
            # More packets behind those in flight would only delay the sound.
            return max(wait_s, min(self._trained_s + _PROBE_EVERY_S - now_s, _RETRY_S))
        return wait_s

    def is_free_for_keyframe(self, now_s: float) -> bool:
        """Whether nothing is queued on the link but a packet that has just been sent."""
        return self._pacer.free_in_s(now_s) <= PACKET_BITS / self._pacer.rate_bps

    def plan_train(self, size_bytes: int, now_s: float) -> Train:
        self._trained_s, self._is_another_link = now_s, False
        return self._estimator.plan_train(size_bytes, now_s)

    @property
    def payload_bytes(self) -> int:
        return payload_bytes(self._pacer.rate_bps)

    def may_retransmit(self, size_bytes: int, age_s: float, now_s: float) -> bool:
        known = self._estimate or self.estimate(now_s)
        is_stale = age_s > _STALE_S + (known.round_trip_ms or 0.0) / 1000
        if is_stale or known.state == "blind" or known.queue_ms > _FULL_QUEUE_MS:
            return False
        allowed_bps = _RETRANSMISSION_SHARE * known.rate_bps
        gone_s = max(now_s - self._retransmitted_s, 0.0)
        self._retransmitted_s = now_s
        burst_bits = _RETRANSMISSION_BURST_S * allowed_bps
        self._retransmitted_bits = max(self._retransmitted_bits - gone_s * allowed_bps, 0.0)
        # The cap matters because the rate may be estimated at a hundred times the picture's.
        self._earned_bits = min(self._earned_bits, burst_bits)
        if self._retransmitted_bits > burst_bits or self._earned_bits < 0:
            return False
        if not self._budget.may_repeat(size_bytes, drives=self.full_feedback, now_s=now_s):
            return False
        self._retransmitted_bits += 8 * size_bytes
        # A retransmission earns nothing: `sent` will credit it, so that is taken back here.
        self._earned_bits -= (1 + _RETRANSMISSION_SHARE) * 8 * size_bytes
        return True

    def _is_stuck(self, unreported_s: float | None) -> bool:
        known = self._estimate
        if known is None:
            return False
        limit_s = _FEEDBACK_S + (known.round_trip_ms or 0.0) / 1000
        is_late = unreported_s is not None and unreported_s > limit_s
        return known.state == "blind" or (is_late and not self._sampling.is_sparse)

    def _update(self, now_s: float) -> None:
        self._updated_s = now_s
        estimate = self.estimate(now_s)
        self._pacer.rate_bps = estimate.rate_bps
        self._pacer.drain(estimate.queue_ms, now_s)
        self._sampling.choose_interval(estimate, full_feedback=self.full_feedback)
        self._on_news(estimate, now_s)
