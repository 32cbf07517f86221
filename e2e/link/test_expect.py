"""The judge of the link: what is within what is promised passes, what is not does not."""

from __future__ import annotations

from random import Random

import pytest
from tests.link.chance import LossChain, jitter_quantile_ms
from tests.link.profile import Jitter, Loss

from e2e.link import expect

NORMAL = Jitter(distribution="normal", ms=5)
PARETO = Jitter(distribution="pareto", ms=8, shape=4, at_most_ms=60)


@pytest.mark.parametrize("jitter", [NORMAL, PARETO, Jitter(distribution="uniform", ms=10)])
def test_true_samples_pass_and_shifted_ones_fail(jitter: Jitter) -> None:
    """Of 200 samples from the promise itself at least 190 pass; 3 ms more, and none of 20 does."""
    random = Random(3)

    def sample(more_ms: float) -> list[float]:
        return [30 + more_ms + jitter_quantile_ms(jitter, random.random()) for _ in range(300)]

    true = [sample(0) for _ in range(200)]
    assert sum(expect.delay_figure(30, jitter, delays).ok for delays in true) >= 190
    assert sum(expect.jitter_figure(jitter, delays).ok for delays in true) >= 190
    assert not any(expect.delay_figure(30, jitter, sample(3)).ok for _ in range(20))


def test_twice_the_jitter_fails() -> None:
    """A spread that is twice what is promised is never within it."""
    random = Random(4)
    wide = Jitter(distribution="normal", ms=10)
    delays_ms = [50 + jitter_quantile_ms(wide, random.random()) for _ in range(300)]
    assert not expect.jitter_figure(NORMAL, delays_ms).ok


def test_bursty_losses_are_given_more_room() -> None:
    """Samples of a bursty chain pass mostly; half of its losses does not."""
    loss = Loss(good_to_bad=0.0222, bad_to_good=0.3333, in_bad=0.8)
    chain = LossChain(Random(5))
    came = [4800 - sum(chain.loses(loss) for _ in range(4800)) for _ in range(100)]
    assert sum(expect.loss_figure(loss, 4800, count).ok for count in came) >= 95
    assert not expect.loss_figure(loss, 4800, 4800 - 120).ok
    assert not expect.loss_figure(Loss(), 4800, 4799).ok


def test_the_rate_is_not_moved_by_a_stall() -> None:
    """1200 bytes each 10 ms are 960 kbit/s, also when 100 ms of them come in one moment."""
    arrivals = [(index / 100, 1200) for index in range(200)]
    stalled = [(1.2 if 1.1 <= at_s < 1.2 else at_s, size) for at_s, size in arrivals]
    assert expect.rate_bps(arrivals) == pytest.approx(960_000)
    assert expect.rate_bps(stalled) == pytest.approx(960_000, rel=0.01)
    assert expect.rate_bps([]) == 0


def test_times_have_a_floor() -> None:
    """Half a millisecond is allowed on any delay, more only on a long one."""
    assert expect.time_figure("delay_ms", 0.2, 0.69, 0).ok
    assert not expect.time_figure("delay_ms", 0.2, 0.71, 0).ok
    assert expect.time_figure("delay_ms", 300, 314, 0).ok
    assert not expect.time_figure("delay_ms", 300, 316, 0).ok
