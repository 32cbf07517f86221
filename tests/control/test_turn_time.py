"""The clock of a turn, and its pauses."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.control.turn_time import MAX_PAUSE_S, TurnTime

STEPS = st.lists(st.tuples(st.floats(0, 100), st.booleans()), max_size=12)


def test_a_clock_that_runs_ends_after_its_time() -> None:
    """Without a pause a turn ends when its time is up."""
    time = TurnTime(10.0, 60.0)
    assert (time.ends_s, time.left_at(30.0), time.is_paused_at(30.0)) == (70.0, 40.0, False)


def test_a_clock_that_stands_keeps_what_is_left() -> None:
    """A pause of 10 s does not use up the turn, which ends 10 s later."""
    standing = TurnTime(0.0, 60.0).paused(True, 20.0)
    assert standing.left_at(30.0) == 40.0
    assert standing.is_paused_at(30.0)
    assert standing.paused(False, 30.0).ends_s == 70.0


def test_it_stands_a_minute_in_all() -> None:
    """After 60 s of pauses in total the clock runs on."""
    standing = TurnTime(0.0, 60.0).paused(True, 10.0)
    assert standing.ends_s == 60.0 + MAX_PAUSE_S
    assert not standing.is_paused_at(10.0 + MAX_PAUSE_S)
    assert standing.left_at(10.0 + MAX_PAUSE_S + 5.0) == 45.0
    again = standing.paused(False, 30.0).paused(True, 35.0)
    assert again.pause_left_s == MAX_PAUSE_S - 20.0


def test_pausing_twice_changes_nothing() -> None:
    """Setting the same state again changes nothing, so no rounding error accumulates."""
    time = TurnTime(0.0, 60.0)
    assert time.paused(False, 3.0) is time


@examples(200)
@given(STEPS)
def test_no_turn_is_shorter_or_much_longer(steps: list[tuple[float, bool]]) -> None:
    """However it is paused, a turn lasts exactly its time plus its pauses."""
    time, now_s, stood_s = TurnTime(0.0, 60.0), 0.0, 0.0
    for pass_s, is_paused in steps:
        if time.is_paused:
            may_stand_s = time.since_s + time.pause_left_s - now_s
            stood_s += max(0.0, min(pass_s, may_stand_s))
        now_s += pass_s
        if now_s >= time.ends_s:
            break
        time = time.paused(is_paused, now_s)
        assert abs(time.left_at(now_s) - (60.0 + stood_s - now_s)) < 1e-6
        assert time.ends_s <= 60.0 + MAX_PAUSE_S + 1e-6
        assert time.pause_left_s >= -1e-6
