"""The upload is never promised twice, and is shared evenly among those who want it."""

from __future__ import annotations

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.upload_budget import UploadBudget

WANTS: Final = st.lists(st.floats(1e3, 1e7), min_size=1, max_size=12)
UPLOAD: Final = st.floats(1e4, 1e8)


def settled(budget: UploadBudget, wants: list[float], *, operators: int = 0) -> list[float]:
    """Let everybody ask twice, after all have joined; the first `operators` of them drive."""
    for now_s in (100.0, 102.0):
        shares = [
            budget.share_bps(who, bps, drives=who < operators, now_s=now_s)
            for who, bps in enumerate(wants)
        ]
    return shares


@given(UPLOAD, WANTS, st.integers(0, 1))
def test_all_together_stay_under_it(upload_bps: float, wants: list[float], operators: int) -> None:
    """Whoever watches, the sum stays below the upload, and nobody gets more than they want."""
    shares = settled(UploadBudget(upload_bps), wants, operators=operators)
    assert sum(shares) <= upload_bps
    assert all(0 <= share <= bps for share, bps in zip(shares, wants, strict=True))


@given(UPLOAD, WANTS)
def test_nobody_has_more_than_one_who_wants_more(upload_bps: float, wants: list[float]) -> None:
    """Max-min: whoever gets less than they want gets as much as anybody, and nothing is unused."""
    shares = settled(UploadBudget(upload_bps), wants)
    short = [share for share, bps in zip(shares, wants, strict=True) if share < bps]
    if short:
        assert min(short) == pytest.approx(max(shares))
        assert sum(shares) == pytest.approx(0.9 * upload_bps)


@given(UPLOAD, WANTS)
def test_the_operator_is_served_before_anybody(upload_bps: float, wants: list[float]) -> None:
    """A crowd takes nothing from the operator."""
    alone = UploadBudget(upload_bps).share_bps(0, wants[0], drives=True, now_s=1.0)
    assert settled(UploadBudget(upload_bps), wants, operators=1)[0] == alone


@given(UPLOAD, WANTS)
def test_one_more_is_told_what_they_would_get(upload_bps: float, wants: list[float]) -> None:
    """`next_bps` is what a new observer then gets, however much they want."""
    budget = UploadBudget(upload_bps)
    settled(budget, wants)
    promised_bps = budget.next_bps()
    assert settled(budget, [*wants, 1e12])[-1] == pytest.approx(promised_bps)


def test_what_somebody_leaves_is_the_others() -> None:
    """A leaving viewer's share goes to the others at once, and only once."""
    budget = UploadBudget(1e6)
    settled(budget, [1e6, 1e6])
    budget.leave(0)
    budget.leave(0)
    assert budget.share_bps(1, 1e6, drives=False, now_s=102.0) == pytest.approx(0.9e6)


def test_a_turn_takes_effect_at_once() -> None:
    """An observer who starts to drive gets the operator's share at once."""
    budget = UploadBudget(1e6)
    settled(budget, [1e6, 1e6])
    assert budget.share_bps(0, 0.6e6, drives=False, now_s=102.0) == pytest.approx(0.45e6)
    assert budget.share_bps(0, 0.6e6, drives=True, now_s=102.0) == pytest.approx(0.6e6)
    assert budget.share_bps(1, 1e6, drives=False, now_s=102.0) == pytest.approx(0.3e6)


def test_without_a_limit_everybody_gets_what_they_want() -> None:
    """0, the default, means no limit."""
    budget = UploadBudget(0)
    assert settled(budget, [1e9] * 50) == [1e9] * 50
    assert budget.next_bps() == float("inf")
