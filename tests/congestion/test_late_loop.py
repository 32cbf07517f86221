"""While the event loop is late, observers are sent less; the operator is not."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.late_loop import LateLoop, MeanDelay
from wax.congestion.upload_budget import UploadBudget

WANTED_BPS = 20e6


class Seconds:
    """Gives a `LateLoop` one second after another, each with the same delay."""

    def __init__(self) -> None:
        self.loop = LateLoop()

    def last(self, seconds: int, late_s: float, *, observers: int = 20) -> float:
        for _ in range(seconds):
            self.loop.update(late_s, wanted_bps=WANTED_BPS, observers=observers)
        return self.loop.most_bps


def test_a_loop_on_time_limits_nobody() -> None:
    """The delays before a rush of work, and single late ticks, cut nothing."""
    assert Seconds().last(60, 0.007) == math.inf


def test_the_cut_lasts_as_long_as_the_loop_is_late_and_goes_slowly() -> None:
    """Each late second takes a fifth; it takes half a minute to get all of it back."""
    seconds = Seconds()
    assert seconds.last(3, 0.0151) <= 0.52 * WANTED_BPS
    held = seconds.last(20, 0.01)
    assert held <= 0.52 * WANTED_BPS
    assert seconds.last(10, 0.002) < WANTED_BPS
    assert seconds.last(10, 0.002) == math.inf


def test_a_mean_delay_is_of_what_came_since_the_last() -> None:
    """Neither earlier delays nor a second without any count."""
    delay = MeanDelay()
    assert delay.since_last(50, 5.0) == 0.1
    assert delay.since_last(50, 5.0) == 0
    assert math.isclose(delay.since_last(60, 5.2), 0.02)


def test_what_is_much_too_late_is_cut_at_once() -> None:
    """A second of 60 ms leaves less than half; four seconds of 20 ms would."""
    assert Seconds().last(1, 0.06) < 0.5 * WANTED_BPS


@given(st.lists(st.floats(0, 1), max_size=40), st.integers(0, 100))
def test_no_observer_loses_everything(late_s: list[float], observers: int) -> None:
    """However late the loop is, each keeps what sound and a small picture take."""
    seconds = Seconds()
    for one_s in late_s:
        assert seconds.last(1, one_s, observers=observers) >= 100_000 * observers


def test_an_empty_room_keeps_no_limit() -> None:
    """Whoever comes first after a late second is served as on any other."""
    assert Seconds().last(5, 0.5, observers=0) == math.inf


@given(st.lists(st.floats(1e3, 1e7), min_size=2, max_size=12), st.floats(0, 1e8))
def test_only_observers_are_limited(wants: list[float], most_bps: float) -> None:
    """They share the limit; the operator, the first of them, gets what they want."""
    budget = UploadBudget(0)
    budget.limit_observers(most_bps)
    for now_s in (100.0, 102.0):
        shares = [
            budget.share_bps(who, bps, drives=who == 0, now_s=now_s)
            for who, bps in enumerate(wants)
        ]
    assert shares[0] == wants[0]
    assert sum(shares[1:]) <= most_bps * (1 + 1e-9) or shares[1:] == wants[1:]
    assert budget.next_bps() == math.inf
