"""Which form the sound has, how much of it is sent again, and what that leaves to the picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.congestion.wire_cost import sound_bps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import SoundForm

_SHARE: Final = 3
"""Sound takes at most one part in three; its smallest form stays whatever it takes."""
_HOLD_S: Final = 5.0

_LOSS: Final = 0.005
_LOSS_OVER: Final = 0.0025
_MOST_AGAIN: Final = 3
_AGAIN_HOLD_S: Final = 10.0


@dataclass(frozen=True, slots=True)
class Budget:
    """What a share of the link's rate leaves to sound and picture: it, less what others take."""

    rate_bps: float
    share: float
    other_bps: float

    @property
    def bps(self) -> float:
        return self.share * self.rate_bps - self.other_bps


class SoundChoice:
    """Told of the link at every decision; `now_s` never falls."""

    def __init__(self, forms: Sequence[SoundForm]) -> None:
        self._forms = tuple(forms)
        self._form: SoundForm | None = None
        self._better_since_s: float | None = None
        self._again = 0
        self._fewer_since_s: float | None = None
        self._aim: tuple[SoundForm, int] | None = None
        self._considered: tuple[SoundForm, ...] = ()

    def choose(
        self,
        budget: Budget,
        fixed: SoundForm | None,
        *,
        alone: bool,
        lost: float,
        burst: int,
        quick: bool,
        now_s: float,
    ) -> tuple[SoundForm, int]:
        """Return the form and how many earlier units go with each.

        Down at once; up at once only where it is to be `quick`, else after it fitted for 5 s.
        `alone` is sound without a picture: it may take everything.
        """
        forms = (fixed,) if fixed is not None else self._forms
        self._considered = forms
        self._follow_loss(lost, burst, now_s)
        third_bps = budget.bps if alone else budget.bps / _SHARE
        best = next((form for form in forms if sound_bps(form, 0) <= third_bps), forms[-1])
        form = self._held(forms, best, quick=quick, now_s=now_s)
        self._form = form
        self._aim = (best, self._affordable(best, third_bps))
        return form, self._affordable(form, third_bps)

    def left_bps(self, chosen_by: Budget, share: float) -> float:
        """Return what is left to the picture of a `share` of the rate, after `choose`.

        A faster link never leaves less: shortly before the next better sound would fit, the
        picture is given no more than it will keep then.
        """
        if self._aim is None:
            return Budget(chosen_by.rate_bps, share, chosen_by.other_bps).bps
        left_bps = Budget(chosen_by.rate_bps, share, chosen_by.other_bps).bps - sound_bps(
            *self._aim
        )
        for form in self._considered:
            for again in range(self._again + 1):
                takes_bps = sound_bps(form, again)
                if takes_bps * _SHARE > chosen_by.bps:
                    from_bps = (takes_bps * _SHARE + chosen_by.other_bps) / chosen_by.share
                    then = Budget(from_bps, share, chosen_by.other_bps)
                    left_bps = min(left_bps, then.bps - takes_bps)
        return left_bps

    def none(self) -> None:
        """No sound is wanted now."""
        self._aim = None
        self._form = None

    def _held(
        self, forms: tuple[SoundForm, ...], best: SoundForm, *, quick: bool, now_s: float
    ) -> SoundForm:
        if self._form not in forms or quick or forms.index(best) >= forms.index(self._form):
            self._better_since_s = None
            return best
        if self._better_since_s is None:
            self._better_since_s = now_s
        if now_s - self._better_since_s < _HOLD_S:
            return self._form
        self._better_since_s = None
        return best

    def _follow_loss(self, lost: float, burst: int, now_s: float) -> None:
        limit = _LOSS_OVER if self._again else _LOSS
        wanted = min(burst, _MOST_AGAIN) if lost >= limit else 0
        if wanted >= self._again:
            self._again, self._fewer_since_s = wanted, None
        elif self._fewer_since_s is None:
            self._fewer_since_s = now_s
        elif now_s - self._fewer_since_s >= _AGAIN_HOLD_S:
            self._again, self._fewer_since_s = wanted, None

    def _affordable(self, form: SoundForm, third_bps: float) -> int:
        counts = range(self._again, 0, -1)
        return next((count for count in counts if sound_bps(form, count) <= third_bps), 0)
