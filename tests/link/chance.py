"""Random jitter, stalls and losses of a link, all from seeded numbers."""

from __future__ import annotations

import math
from random import Random
from statistics import NormalDist
from typing import TYPE_CHECKING, Final

from tests.link.profile import NORMAL_CUT

if TYPE_CHECKING:
    from tests.link.profile import Jitter, Loss, Stalls

_NORMAL: Final = NormalDist()
_LEAST: Final = _NORMAL.cdf(-NORMAL_CUT)


def jitter_quantile_ms(jitter: Jitter | None, share: float) -> float:
    """Return the jitter that `share` (0…1) of the packets stay below; never falls with it."""
    if jitter is None:
        return 0.0
    if jitter.distribution == "uniform":
        return jitter.ms * (2 * share - 1)
    if jitter.distribution == "normal":
        return jitter.ms * _NORMAL.inv_cdf(min(max(share, _LEAST), 1 - _LEAST))
    if jitter.distribution == "half-normal":
        return jitter.ms * _NORMAL.inv_cdf(min((1 + max(share, 0.0)) / 2, 1 - _LEAST))
    if share >= 1:
        return jitter.at_most_ms
    tail_ms = jitter.ms * (math.pow(1 - share, -1 / jitter.shape) - 1)
    return min(tail_ms, jitter.at_most_ms)


class StallClock:
    """Draws the stalls; their times do not depend on the calls."""

    def __init__(self, random: Random, start_s: float) -> None:
        self._random = random
        self._begin_s = self._end_s = start_s
        self._drawn = False

    def release_s(self, stalls: Stalls | None, time_s: float) -> float:
        """Return `time_s`, or the end of the stall at that time; `time_s` never falls."""
        if stalls is None:
            return time_s
        while not self._drawn or self._end_s <= time_s:
            self._begin_s = self._end_s + stalls.every_s * self._random.uniform(0.5, 1.5)
            length_ms = self._random.uniform(stalls.at_least_ms, stalls.at_most_ms)
            self._end_s = self._begin_s + length_ms / 1000
            self._drawn = True
        return self._end_s if self._begin_s <= time_s else time_s


class LossChain:
    """The two states of Gilbert and Elliott."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._bad = False

    def loses(self, loss: Loss) -> bool:
        """Decide the next packet's loss, and move the chain by one."""
        chance = self._random.random
        if self._bad:
            self._bad = chance() >= loss.bad_to_good
        else:
            self._bad = chance() < loss.good_to_bad
        return chance() < (loss.in_bad if self._bad else loss.in_good)


def seeded(seed: int, way: str, purpose: str) -> Random:
    """Return a separate generator for each direction and purpose, so that none affects another."""
    return Random(f"{seed} {way} {purpose}")
