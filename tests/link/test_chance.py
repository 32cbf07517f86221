"""Chance: in the long run it is as the profile states, within 5 % and mostly far closer."""

from __future__ import annotations

import math
from itertools import groupby, pairwise
from random import Random
from statistics import fmean, pstdev

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.link.chance import LossChain, StallClock, jitter_quantile_ms
from tests.link.profile import Jitter, Loss, Stalls

UNIFORM = Jitter(distribution="uniform", ms=10)
NORMAL = Jitter(distribution="normal", ms=10)
HALF_NORMAL = Jitter(distribution="half-normal", ms=10)
PARETO = Jitter(distribution="pareto", ms=10, shape=3, at_most_ms=200)


def drawn(jitter: Jitter) -> list[float]:
    return [jitter_quantile_ms(jitter, (n + 0.5) / 10_000) for n in range(10_000)]


def test_uniform_jitter_is_uniform() -> None:
    """Half width 10: mean 0, deviation 10/√3, nothing outside."""
    values = drawn(UNIFORM)
    assert fmean(values) == pytest.approx(0, abs=0.1)
    assert pstdev(values) == pytest.approx(10 / math.sqrt(3), rel=0.01)
    assert -10 <= min(values) < -9.9
    assert 9.9 < max(values) <= 10


def test_normal_jitter_is_normal_and_cut() -> None:
    """Deviation 10 (the cut at 3 of them makes it 1.3 % less), mean 0, nothing beyond 30."""
    values = drawn(NORMAL)
    assert fmean(values) == pytest.approx(0, abs=0.15)
    assert pstdev(values) == pytest.approx(10, rel=0.02)
    assert sum(abs(value) < 10 for value in values) / len(values) == pytest.approx(0.683, rel=0.01)
    assert max(map(abs, values)) <= 30 + 1e-9


def test_half_normal_jitter_is_the_size_of_normal_jitter() -> None:
    """Mean 10·√(2/π), no packet earlier than the delay, nothing beyond 30."""
    values = drawn(HALF_NORMAL)
    assert fmean(values) == pytest.approx(10 * math.sqrt(2 / math.pi), rel=0.02)
    assert 0 <= min(values) < 0.1
    assert 29 < max(values) <= 30 + 1e-9


def test_pareto_jitter_has_the_tail_of_lomax() -> None:
    """A fraction of (1 + x/10)^−3 of the values exceeds x; none is negative or above the cut."""
    values = drawn(PARETO)
    for beyond_ms in (5, 10, 50):
        share = sum(value > beyond_ms for value in values) / len(values)
        assert share == pytest.approx((1 + beyond_ms / 10) ** -3, rel=0.1)
    assert min(values) >= 0
    assert max(values) <= 200


@pytest.mark.parametrize("jitter", [UNIFORM, NORMAL, HALF_NORMAL, PARETO, None])
@given(share=st.floats(0, 1), other=st.floats(0, 1))
def test_a_quantile_never_falls(jitter: Jitter | None, share: float, other: float) -> None:
    """A larger share has no smaller jitter, at both ends of the scale too."""
    low, high = sorted((share, other))
    assert jitter_quantile_ms(jitter, low) <= jitter_quantile_ms(jitter, high)


def lost(loss: Loss, count: int = 200_000) -> list[bool]:
    chain = LossChain(Random(1))
    return [chain.loses(loss) for _ in range(count)]


def test_random_losses_stand_alone() -> None:
    """Independent: after a loss the next packet is as likely to be lost as after none."""
    fate = lost(Loss(in_good=0.1))
    after = [later for earlier, later in pairwise(fate) if earlier]
    assert fmean(after) == pytest.approx(0.1, rel=0.05)


def test_bursts_are_as_long_as_stated() -> None:
    """If the bad state loses all, a burst lasts 1 / bad_to_good packets on average."""
    loss = Loss(good_to_bad=0.0125, bad_to_good=0.25)
    fate = lost(loss)
    bursts = [len(list(run)) for is_lost, run in groupby(fate) if is_lost]
    assert fmean(bursts) == pytest.approx(4, rel=0.05)
    assert fmean(fate) == pytest.approx(loss.mean, rel=0.05)


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0.01, 1))
def test_the_mean_is_between_the_states(a: float, b: float, enter: float, leave: float) -> None:
    """The long-run loss lies between those of the two states."""
    loss = Loss(in_good=a, in_bad=b, good_to_bad=enter, bad_to_good=leave)
    assert min(a, b) - 1e-12 <= loss.mean <= max(a, b) + 1e-12


STALLS = Stalls(every_s=2, at_least_ms=100, at_most_ms=300)


def windows() -> list[tuple[float, float]]:
    """Return the stalls of 500 s, each as first held time and release, looking at each ms."""
    clock = StallClock(Random(1), 0.0)
    found: dict[float, float] = {}
    for tick in range(500_000):
        time_s = tick / 1000
        released_s = clock.release_s(STALLS, time_s)
        if released_s > time_s:
            found.setdefault(released_s, time_s)
    return [(begin_s, end_s) for end_s, begin_s in found.items()]


def test_stalls_come_as_often_and_last_as_long_as_stated() -> None:
    """Between stalls lie 1 to 3 s, on average 2; they last from 100 to 300 ms, on average 200."""
    seen = windows()
    lengths_ms = [(end_s - begin_s) * 1000 for begin_s, end_s in seen]
    gaps_s = [begin_s - end_s for (_, end_s), (begin_s, _) in pairwise(seen)]
    assert fmean(gaps_s) == pytest.approx(2, rel=0.05)
    assert min(gaps_s) >= 1
    assert max(gaps_s) <= 3.002
    assert fmean(lengths_ms) == pytest.approx(200, rel=0.05)
    assert min(lengths_ms) >= 98
    assert max(lengths_ms) <= 301


@given(st.lists(st.floats(0, 3), max_size=30), st.lists(st.floats(0, 3), max_size=30))
def test_stalls_do_not_depend_on_who_asks(some: list[float], others: list[float]) -> None:
    """The clock's answer for a time does not depend on the earlier questions."""
    answers = []
    for gaps_s in (some, others):
        clock, now_s = StallClock(Random(7), 0.0), 0.0
        for gap_s in gaps_s:
            now_s += gap_s
            assert clock.release_s(STALLS, now_s) >= now_s
        answers.append([clock.release_s(STALLS, 90 + tick / 50) for tick in range(200)])
    assert answers[0] == answers[1]
