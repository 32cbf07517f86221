"""At most so many within any minute."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.session.minute_limits import MinuteLimits


@given(gaps_s=st.lists(st.floats(0.0, 40.0), max_size=60), each=st.integers(1, 5))
def test_no_minute_has_more(gaps_s: list[float], each: int) -> None:
    """Requests may come at any time, and one within the limit is never refused."""
    limits = MinuteLimits(each=each, most=4)
    now_s, taken_s = 0.0, list[float]()
    for gap_s in gaps_s:
        now_s += gap_s
        recent = sum(now_s - one_s < 60.0 for one_s in taken_s)
        assert limits.taken("a", now_s) == recent
        assert limits.take("a", now_s) is (recent < each)
        if recent < each:
            taken_s.append(now_s)


def test_the_least_recent_is_forgotten() -> None:
    """However many keys come, few are kept; the most recent one is among them."""
    limits = MinuteLimits(each=1, most=3)
    assert [limits.take(key, 0.0) for key in "abcd"] == [True] * 4
    assert [limits.take(key, 1.0) for key in "dcba"] == [False, False, False, True]
