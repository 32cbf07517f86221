"""How fast a robot may run so that it stops in time."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rules import RULES

from wax.control.stopping_distance import fastest_mps, unnoticed_s


@pytest.mark.parametrize(("watchdog_s", "expected_s"), [(0.12, 0.27), (0.25, 0.27), (0.4, 0.42)])
def test_the_slowest_watchdog_counts(watchdog_s: float, expected_s: float) -> None:
    """The time until the loss is noticed is the longest watchdog timeout, plus a tick."""
    assert unnoticed_s(0.25, replace(RULES, watchdog_s=watchdog_s)) == pytest.approx(expected_s)


@pytest.mark.parametrize(("watchdog_s", "expected_s"), [(0.12, 0.39), (0.4, 0.42)])
def test_a_late_server_looks_late(watchdog_s: float, expected_s: float) -> None:
    """The gate may check late, by as much as the driver process tolerates."""
    rules = replace(RULES, watchdog_s=watchdog_s, silence_s=0.12)
    assert unnoticed_s(0.25, rules) == pytest.approx(expected_s)


def test_example() -> None:
    """At 0.6 m/s, after 0.3 s unnoticed and braking at 2 m/s², a robot stops within 0.27 m."""
    rules = replace(RULES, max_stop_distance_m=0.6 * 0.3 + 0.6**2 / (2 * 2.0), watchdog_s=0.0)
    assert fastest_mps(0.28, rules) == pytest.approx(0.6)


@given(
    ttl_s=st.floats(0.05, 2.0),
    distance_m=st.floats(1e-6, 10.0),
    braking_mps2=st.floats(1e-3, 100.0),
    watchdog_s=st.floats(0.06, 1.0),
)
def test_distance_is_used_up_and_not_exceeded(
    ttl_s: float, distance_m: float, braking_mps2: float, watchdog_s: float
) -> None:
    """At the fastest speed the robot travels the configured distance, and never more."""
    rules = replace(
        RULES,
        max_stop_distance_m=distance_m,
        braking_mps2=braking_mps2,
        watchdog_s=watchdog_s,
    )
    speed_mps, t_s = fastest_mps(ttl_s, rules), unnoticed_s(ttl_s, rules)
    travelled_m = speed_mps * t_s + speed_mps**2 / (2 * braking_mps2)
    assert travelled_m == pytest.approx(distance_m, rel=1e-9)
