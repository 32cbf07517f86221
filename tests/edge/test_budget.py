"""Budgets of time: nobody waits within the committed rate, or gets more than their share."""

from __future__ import annotations

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.edge.budget import Budget, Rates

RATES: Final = Rates(committed=0.01, committed_burst_s=0.02, pool=0.1, pool_burst_s=0.1)
STEP_S: Final = 0.001


def test_the_committed_rate_is_served_at_once() -> None:
    """Somebody who stays within it never waits, even when others have used up the pool."""
    budget = Budget(RATES)
    honest, flooders = budget.payer("a"), [budget.payer("b") for _ in range(20)]
    for millisecond in range(2000):
        now_s = millisecond / 1000
        for one in flooders:
            if one.wait_s(now_s) == 0:
                one.spend(STEP_S, now_s)
        if millisecond % 100 == 0:
            assert honest.wait_s(now_s) == 0
            honest.spend(STEP_S, now_s)


def test_an_unused_pool_is_free_for_one_payer() -> None:
    """One address may use half of it: somebody who connects alone is not slowed down."""
    one = Budget(RATES).payer("a")
    spent_s = 0.0
    while one.wait_s(0.0) == 0:
        one.spend(STEP_S, 0.0)
        spent_s += STEP_S
    assert spent_s == pytest.approx(0.02 + 0.05, abs=2 * STEP_S)


def test_one_address_leaves_half_of_the_pool() -> None:
    """However many viewers it has, somebody elsewhere can still exceed the committed rate."""
    budget = Budget(RATES)
    crowd = [budget.payer("a") for _ in range(50)]
    for one in crowd:
        while one.wait_s(0.0) == 0:
            one.spend(STEP_S, 0.0)
    other = budget.payer("b")
    other.spend(0.02, 0.0)
    assert other.wait_s(0.0) == 0


def test_a_debt_is_paid_before_the_next_step() -> None:
    """A step may overdraw the account; the next one waits until the debt is paid."""
    one = Budget(Rates(committed=0.01, committed_burst_s=0.02, pool=0, pool_burst_s=0)).payer("")
    one.spend(0.025, 0.0)
    assert one.wait_s(0.0) == pytest.approx(0.5)
    assert one.wait_s(0.4) == pytest.approx(0.1)
    assert one.wait_s(0.6) == 0


def test_nobody_waits_for_longer_than_a_second() -> None:
    """A pause of the whole process is charged to the running step's payer, innocent or not."""
    one = Budget(RATES).payer("")
    for _ in range(3):
        one.spend(10.0, 0.0)
    assert 0 < one.wait_s(0.0) <= 1.0
    assert one.wait_s(1.001) == 0


def test_a_clock_that_runs_backwards_changes_nothing() -> None:
    """It neither refills nor drains an account."""
    one = Budget(RATES).payer("")
    one.spend(0.019, 100.0)
    assert one.wait_s(50.0) == 0
    one.spend(0.08, 50.0)
    one.spend(0.001, 50.0)
    assert one.wait_s(50.0) > 0


@examples(100)
@given(
    asks=st.lists(
        st.tuples(st.integers(0, 5), st.floats(0, 0.05), st.floats(1e-5, STEP_S)), max_size=300
    )
)
def test_all_together_use_no_more_than_was_given(asks: list[tuple[int, float, float]]) -> None:
    """In any sequence, the sum stays below bursts + rates × time + one step for each payer."""
    budget = Budget(RATES)
    payers = [budget.payer("a" if number < 3 else "b") for number in range(6)]
    now_s = spent_s = 0.0
    for number, pause_s, cost_s in asks:
        now_s += pause_s
        if payers[number].wait_s(now_s) == 0:
            payers[number].spend(cost_s, now_s)
            spent_s += cost_s
        given_s = 6 * (0.02 + 0.01 * now_s) + 0.1 + 0.1 * now_s
        assert spent_s <= given_s + 7 * STEP_S
