"""The rate from losses alone."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.loss import LossBasedControl


def test_it_rises_slowly_and_falls_with_what_is_lost() -> None:
    """Without loss the rate grows by 8 % a second; losing half costs it a quarter at once."""
    rate = LossBasedControl()
    for second in range(11):
        rate.reported(0.0, float(second))
    assert 5e6 * 1.08**10 * 0.99 < rate.rate_bps < 5e6 * 1.08**10 * 1.01
    before_bps = rate.rate_bps
    rate.reported(0.5, 11.0)
    assert rate.rate_bps == before_bps * 0.75


def test_a_little_loss_is_let_be() -> None:
    """Loss between 2 and 10 % leaves the rate: it comes from radio, not from a queue."""
    rate = LossBasedControl()
    for second in range(20):
        rate.reported(0.05, float(second))
    assert rate.rate_bps == 5e6


@given(st.lists(st.floats(0, 1), max_size=60))
def test_whatever_is_lost_it_stays_in_its_bounds(shares: list[float]) -> None:
    """No report takes the rate out of 30 kbit/s to 20 Mbit/s."""
    rate = LossBasedControl()
    for second, lost in enumerate(shares):
        rate.reported(lost, float(second))
        assert 30e3 <= rate.rate_bps <= 20e6
