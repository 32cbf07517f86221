"""Chooses the step of the rendition ladder that one viewer's link carries, with few changes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.congestion.allocation import Allocation, area
from wax.congestion.sound_choice import FIT_SHARE, SoundChoice
from wax.congestion.sound_choice import REDUNDANCY_LOSS_SHARE as _LOSSY
from wax.congestion.upgrade_backoff import Since, Trials
from wax.congestion.wire_cost import picture_bps
from wax.rate_limits import TokenBucket
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import SoundEncoding, Step
    from wax.congestion.control import LinkEstimate

_KEEP_SHARE: Final = 0.95
"""A step keeps all its layers up to this share of the rate: hysteresis."""
_LAST_SHARE: Final = 1.1
"""Share for the smallest step: the pacer then drops single pictures, upper layers first."""
_SELDOM_SHARE: Final = 0.8
"""The smallest step's lowest layer is kept while this share of it fits: an occasional picture,
while the pacer drops the others, is better than none."""
_BETWEEN_S: Final = 5.0
"""Minimum time between steps: a keyframe costs as much as several pictures."""
_FALL_HOLD_S: Final = 1.0
"""A step with dropped layers is given up after this time."""
_GIVE_UP_HOLD_S: Final = 4.0
"""The picture is given up when not even its lowest layer has fitted for this long. Until then
pictures wait for the pacer: a burst of messages ends sooner than a given-up picture returns."""
_WISHES_HZ: Final = 0.05
"""Somebody who looks closer three times a minute never waits."""
_WISHES_BURST: Final = 4
"""Larger pictures that a viewer gets at once by wish; beyond that a wish waits as an upgrade does,
because each one takes a keyframe, and perhaps one more encoder."""
_FULL_QUEUE_MS: Final = 100.0
"""No keyframe is sent behind a longer queue: it would be old on arrival."""
_PAUSE_S: Final = 5.0
"""A picture that was given up returns once it has fitted for this long. Otherwise it is tried for
this long after a pause of this length, because nothing else probes the link."""
_MAX_PAUSE_S: Final = 60.0
"""The longest pause; each failed trial doubles it."""
_REST_S: Final = 0.3
"""The least time between two decisions about a link that is no worse; `feedback` samples a settled
one less often."""
_SAME_SHARE: Final = 0.98
"""A rate above this share of the one decided on is no worse: hysteresis takes up the rest."""


class Allocator:
    """Chooses sound, step and layers for one viewer.

    A downgrade is immediate: one decision drops upper layers, and the step follows. An upgrade
    waits until the better step has fitted for a while, longer after each failed upgrade, with at
    most one step in 5 s; during startup, and for the first few wishes, it is immediate, too.
    """

    def __init__(self, steps: Sequence[Step], sounds: Sequence[SoundEncoding]) -> None:
        """Raise ValueError if there is no step, no sound, or an invalid size."""
        if not steps or not sounds:
            raise ValueError("a ladder needs at least one step and one encoding of the sound")
        self._steps = tuple(sorted(steps, key=lambda step: -step.bitrate_bps))
        self._areas = tuple(area(step.size) for step in self._steps)
        self._sound = SoundChoice(sounds)
        self._now_s = -math.inf
        self._at: int | None = None
        self._best: int | None = None
        """The best step of a size that is wanted; None while no picture is."""
        self._wishes = TokenBucket(_WISHES_HZ, _WISHES_BURST)
        self._cut = 0
        self._changed_s = -math.inf
        self._trials = Trials()
        self._better = Since()
        self._worse = Since()
        self._whole = Since()
        self._unfit = Since()
        self._try_until_s = -math.inf
        self._gone_s: float | None = None
        self._pause_s = _PAUSE_S
        self._decided: LinkEstimate | None = None
        self._decided_s = self._spare_bps = -math.inf

    def may_rest(self, estimate: LinkEstimate, other_bps: float, now_s: float) -> bool:
        """Return whether a decision for the same wishes can wait, because the link is no worse.

        Feedback comes twenty times a second, and upgrades wait for a second anyway.
        """
        known = self._decided
        return (
            known is not None
            and now_s - self._decided_s < _REST_S
            and known.state == estimate.state != "starting"
            and known.burst >= estimate.burst
            and (known.lost >= _LOSSY or estimate.lost < _LOSSY)
            and (known.queue_ms > _FULL_QUEUE_MS) == (estimate.queue_ms > _FULL_QUEUE_MS)
            and estimate.rate_bps - other_bps >= _SAME_SHARE * self._spare_bps
        )

    def decide(
        self,
        estimate: LinkEstimate,
        *,
        size: str | None,
        sound: bool,
        sound_encodings: Sequence[SoundEncoding] | None,
        other_bps: float,
        now_s: float,
        sound_channels: int = 1,
        takes_redundancy: bool = True,
    ) -> Allocation:
        """Decide what is sent from now on.

        `size` is the largest picture wanted ("640x480"), None for none; `sound_encodings` are the
        configured ones, None to choose among all, and `sound_channels` is the source's channel
        count. Without `takes_redundancy` no sound is repeated. ValueError if `size` is invalid.
        """
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        self._decided, self._decided_s = estimate, self._now_s
        self._spare_bps = estimate.rate_bps - other_bps
        allowed: list[int] = []
        least_bps = 0.0
        if size is not None:
            most = max(area(size), min(self._areas))
            allowed = [at for at, other in enumerate(self._areas) if other <= most]
            least = self._steps[allowed[-1]]
            least_bps = picture_bps(least, least.layers, estimate.rate_bps)
        encoding, redundancy = self._sound.choose(
            estimate,
            other_bps,
            sound_encodings,
            wanted=sound,
            channels=sound_channels,
            picture_bps=least_bps,
            takes_redundancy=takes_redundancy,
            now_s=self._now_s,
        )
        if not allowed:
            self._at, self._best, self._gone_s, self._unfit = None, None, None, Since()
            return Allocation(None, 0, encoding, redundancy, Sentence("sent.no_picture"))
        is_wished = self._is_wished(allowed[0])
        self._best = allowed[0]
        self._follow(estimate, allowed, is_wished=is_wished)
        reason = self._reason(estimate, allowed)
        if self._at is None:
            return Allocation(None, 0, encoding, redundancy, reason)
        step, tries = self._steps[self._at], self._now_s < self._try_until_s
        top = step.layers - self._cut
        left = self._left(estimate, allowed)
        return Allocation(step, top, encoding, redundancy, reason, tries, *left)

    def _is_wished(self, best: int) -> bool:
        """Whether the viewer now wants a larger picture, and gets it at once if it fits."""
        is_larger = self._at == self._best > best if self._best is not None else True
        return is_larger and not self._trials.is_doubtful and self._wishes.take(self._now_s)

    def _left(self, estimate: LinkEstimate, allowed: Sequence[int]) -> tuple[float, float]:
        """Return the rates that other cameras may start with and keep; 0 while layers are cut."""
        if self._at is None or self._cut > 0 or estimate.assumed or estimate.state == "blind":
            return 0.0, 0.0
        now_bps = picture_bps(self._steps[self._at], 0, estimate.rate_bps)
        kept_bps = self._sound.left_bps(_KEEP_SHARE) - now_bps
        if estimate.state != "steady":
            return 0.0, max(kept_bps, 0.0)
        # Reserve the step that the driving view is about to rise to.
        next_at = min(self._at, self._target(estimate, allowed))
        next_bps = picture_bps(self._steps[next_at], 0, estimate.rate_bps)
        left_bps = self._sound.left_bps(FIT_SHARE) - next_bps
        return max(left_bps, 0.0), max(kept_bps, 0.0)

    def _follow(self, estimate: LinkEstimate, allowed: Sequence[int], *, is_wished: bool) -> None:
        """Follow the link, and the wish at once if `is_wished`: it, not the link, set the step."""
        now_s, last = self._now_s, allowed[-1]
        quick = estimate.state == "starting"
        calm = quick or estimate.state == "steady"
        target = self._target(estimate, allowed)
        if self._gone_s is not None and not self._comes_back(estimate, last, calm=calm):
            return
        if self._at not in allowed:
            self._move(last if self._at is None and not is_wished else target)
        assert self._at is not None
        cut = self._needed_cut(estimate, self._at, is_last=self._at == last)
        if cut is None and self._at != last:
            self._trials.record_downgrade(now_s)
            if estimate.queue_ms > _FULL_QUEUE_MS:
                self._cut = self._steps[self._at].layers
                return
            self._move(max(target, self._at + 1))
            cut = self._needed_cut(estimate, self._at, is_last=self._at == last)
        tries = now_s < self._try_until_s
        if self._unfit.lasts(cut is None, _GIVE_UP_HOLD_S, now_s) and not tries:
            self._at, self._gone_s, self._changed_s = None, now_s, now_s
            return
        # The link's rate is unknown during a trial, so it sends only the lowest layer.
        cut = self._steps[self._at].layers if cut is None or tries else cut
        if cut > self._cut:
            self._trials.record_downgrade(now_s)
        self._cut = cut
        between = quick or is_wished or now_s - self._changed_s >= _BETWEEN_S
        hold_s = 0.0 if quick or is_wished else self._trials.hold_s
        better = calm and target < self._at and self._cut == 0
        if self._better.lasts(better, hold_s, now_s) and between:
            self._move(target)
            if not quick:
                self._trials.record_upgrade(now_s)
        worse = self._cut > 0 and target > self._at
        if self._worse.lasts(worse, _FALL_HOLD_S, now_s) and between:
            self._move(target)
        self._trials.settle(now_s)

    def _target(self, estimate: LinkEstimate, allowed: Sequence[int]) -> int:
        if estimate.assumed:
            return allowed[-1]  # the assumed rate would overload a modem line
        left_bps, rate_bps = self._sound.left_bps(FIT_SHARE), estimate.rate_bps
        fits = (at for at in allowed if picture_bps(self._steps[at], 0, rate_bps) <= left_bps)
        return next(fits, allowed[-1])

    def _needed_cut(self, estimate: LinkEstimate, at: int, *, is_last: bool = False) -> int | None:
        """Return how many layers to drop; None if not even the lowest fits.

        The last step's lowest layer also fits if `_SELDOM_SHARE` of it does.
        """
        left_bps = self._sound.left_bps(_LAST_SHARE if is_last else _KEEP_SHARE)
        step, rate_bps = self._steps[at], estimate.rate_bps
        cuts = range(step.layers + 1)
        fits = (cut for cut in cuts if picture_bps(step, cut, rate_bps) <= left_bps)
        least_bps = _SELDOM_SHARE * picture_bps(step, step.layers, rate_bps)
        return next(fits, step.layers if is_last and least_bps <= left_bps else None)

    def _comes_back(self, estimate: LinkEstimate, last: int, *, calm: bool) -> bool:
        """Return whether the picture that was given up returns, or is tried."""
        assert self._gone_s is not None
        fits = self._needed_cut(estimate, last) is not None
        if self._whole.lasts(fits, _PAUSE_S, self._now_s):
            self._pause_s = _PAUSE_S
        elif calm and self._now_s - self._gone_s >= self._pause_s:
            self._pause_s = min(2 * self._pause_s, _MAX_PAUSE_S)
            self._try_until_s = self._now_s + _PAUSE_S
        else:
            return False
        self._gone_s = None
        self._move(last)
        self._cut = self._steps[last].layers
        return True

    def _move(self, at: int) -> None:
        if at != self._at:
            self._changed_s = self._now_s
            self._cut = 0
        self._at = at

    def _reason(self, estimate: LinkEstimate, allowed: Sequence[int]) -> Sentence:
        rate = _rate(estimate.rate_bps)
        is_link = estimate.limit == "link"
        if estimate.state == "blind":
            return Sentence("sent.blind")
        if self._at is None:
            return Sentence("sent.carries_sound" if is_link else "sent.share_sound", {"rate": rate})
        if self._now_s < self._try_until_s:
            return Sentence("sent.trying")
        if self._at == allowed[0] and self._cut == 0:
            return Sentence("sent.all")
        if estimate.state == "starting":
            return Sentence("sent.starting")
        return Sentence("sent.carries" if is_link else "sent.share", {"rate": rate})


def _rate(bps: float) -> Sentence:
    """Format a rate with two digits; no estimate is more precise."""
    digits = 10 ** max(0, math.floor(math.log10(max(bps, 10))) - 1)
    rounded = round(bps / digits) * digits
    if rounded >= 1e6:
        return Sentence("rate.mbit", {"rate": rounded / 1e6})
    return Sentence("rate.kbit", {"rate": rounded / 1e3})
