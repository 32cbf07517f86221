"""When set-points are sent, and when a standby sends standstill instead."""

from __future__ import annotations

import itertools
import math

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.driver.interface import STANDSTILL, Twist
from wax.robot.ros2.pace import Pace
from wax.robot.ros2.standby_rules import OWES, RESTS, SILENCE_S, StandbyRules, patience_s

AHEAD = Twist(0.3, 0.1)
STEP_S = 0.001


def sent(
    pace: Pace, twist: Twist, start_s: float, for_s: float, *, alone: bool = True
) -> list[float]:
    """Ask every millisecond; return when something is sent."""
    steps = range(round(for_s / STEP_S))
    return [
        start_s + step * STEP_S
        for step in steps
        if pace.next(twist, start_s + step * STEP_S, alone=alone)[0]
    ]


def pace(*, idle_hz: float = 2.0) -> Pace:
    return Pace(rate_hz=50, zeros_s=1.5, idle_hz=idle_hz)


def test_motion_is_repeated_for_ever() -> None:
    """Motion is sent at its rate for as long as it lasts."""
    assert len(sent(pace(), AHEAD, 0.0, 10.0)) in range(498, 502)


def test_a_change_is_sent_at_once() -> None:
    """A change does not wait for the next repeat."""
    it = pace()
    assert it.next(AHEAD, 0.0)[0]
    assert not it.next(AHEAD, 0.005)[0]
    assert it.next(Twist(0.2), 0.006)[0]
    assert it.next(STANDSTILL, 0.007)[0]


def test_standstill_is_sent_fast_and_then_slowly() -> None:
    """After motion, standstill has the full rate for `zeros_s`, and then the slow one."""
    it = pace()
    it.next(AHEAD, 0.0)
    zeros = sent(it, STANDSTILL, 0.02, 5.0)
    fast = [at_s for at_s in zeros if at_s < 1.52]
    assert len(fast) in range(74, 77)
    gaps_s = [later - at for at, later in itertools.pairwise(zeros[len(fast) :])]
    assert all(0.499 < gap_s < 0.502 for gap_s in gaps_s)


def test_without_a_slow_rate_the_topic_is_left_to_others() -> None:
    """With idle_hz = 0 nothing is sent after standstill's time, and no next time is named."""
    it = pace(idle_hz=0.0)
    it.next(AHEAD, 0.0)
    assert max(sent(it, STANDSTILL, 0.02, 5.0)) < 1.53
    assert it.next(STANDSTILL, 6.0) == (False, math.inf)


def test_with_another_publisher_only_the_stop_is_sent() -> None:
    """While somebody else publishes, standstill is sent for its time and no longer."""
    it = pace()
    it.next(AHEAD, 0.0)
    zeros = sent(it, STANDSTILL, 0.02, 5.0, alone=False)
    assert 1.45 < max(zeros) < 1.53


def test_a_stop_is_sent_again_after_standstill() -> None:
    """Each stop is sent at once and for its whole time, even with another publisher."""
    for alone in (True, False):
        it = pace(idle_hz=0.0)
        it.next(AHEAD, 0.0)
        assert max(sent(it, STANDSTILL, 0.02, 5.0, alone=alone)) < 1.53
        it.stopped(6.0)
        zeros = sent(it, STANDSTILL, 6.0, 2.0, alone=alone)
        assert zeros[0] == 6.0
        assert len(zeros) in range(74, 77)
        it.stopped(9.0)
        it.next(STANDSTILL, 9.0, alone=alone)
        it.stopped(10.4)
        assert it.owes(11.89)
        assert not it.owes(11.91)


def test_many_stops_keep_the_rate() -> None:
    """Stops at every tick prolong standstill, but never exceed the rate of motion."""
    it = pace()
    it.next(AHEAD, 0.0)
    zeros = []
    for step in range(10_000):
        it.stopped(step * STEP_S)
        if it.next(STANDSTILL, step * STEP_S)[0]:
            zeros.append(step * STEP_S)
    assert len(zeros) in range(499, 503)


def test_an_early_stop_does_not_shorten_standstill() -> None:
    """A stop right after the connection has opened does not shorten its standstill."""
    it = pace()
    it.stopped(0.0)
    assert len(sent(it, STANDSTILL, 1.0, 1.0)) in range(49, 52)


def test_a_new_connection_repeats_standstill() -> None:
    """After a reconnection standstill is sent again."""
    it = pace()
    it.next(STANDSTILL, 0.0)
    assert not it.next(STANDSTILL, 0.001)[0]
    it.begin()
    assert len(sent(it, STANDSTILL, 0.002, 1.0)) in range(49, 52)


@given(
    st.lists(st.tuples(st.sampled_from([AHEAD, STANDSTILL]), st.floats(0.001, 0.3)), max_size=40)
)
@examples(200)
def test_the_next_time_is_never_late(wants: list[tuple[Twist, float]]) -> None:
    """For any sequence, asking at the named times keeps both rates."""
    it = pace()
    now_s, last_s = 0.0, 0.0
    for twist, for_s in wants:
        end_s = now_s + for_s
        while now_s < end_s:
            due_s = last_s + 0.02 + 1e-6
            owed = it.owes(due_s)
            is_due, again_s = it.next(twist, now_s)
            if is_due:
                assert now_s <= due_s or last_s == 0.0 or not owed
                last_s = now_s
            assert again_s > now_s
            now_s = min(end_s, again_s)


def rules() -> StandbyRules:
    return StandbyRules(rate_hz=50, zeros_s=1.5)


def test_a_standby_is_silent_while_the_driver_reports() -> None:
    """The standby sends nothing while a driver keeps reporting that it owes standstill."""
    it = rules()
    for step in range(100):
        it.handle_reports(OWES, step * 0.05)
        assert not it.next(step * 0.05 + 0.049)[0]


def test_a_standby_acts_for_a_silent_driver_until_it_is_back() -> None:
    """A silent driver that owes standstill counts as dead, until it reports again."""
    it = rules()
    it.handle_reports(OWES, 1.0)
    assert it.next(1.05) == (False, 1.0 + SILENCE_S)
    said = [step for step in range(1000) if it.next(1.0 + SILENCE_S + step * STEP_S)[0]]
    assert said[0] == 0
    assert len(said) in range(49, 52)
    it.handle_reports(OWES, 2.2)
    assert not it.next(2.21)[0]


def test_a_standby_rests_while_the_robot_stands() -> None:
    """A driver that owes nothing may be silent; only its end makes the standby send."""
    it = rules()
    it.handle_reports(OWES + RESTS, 1.0)
    assert it.next(50.0) == (False, math.inf)
    it.ended(60.0)
    assert it.next(60.0)[0]
    assert not it.is_over(61.49)
    assert it.is_over(61.5)


def test_a_drivers_end_is_counted_once() -> None:
    """However often the end is reported, standstill lasts for its time from the first."""
    it = rules()
    it.ended(1.0)
    it.ended(2.0)
    assert it.is_over(2.5)


def test_a_standby_has_less_time_once_it_reaches_the_robot() -> None:
    """It may be silent for 1 s; while connecting, for 20 s and its pause between attempts."""
    assert patience_s(1, 60.0) == patience_s(None, 60.0) == 1.0
    assert patience_s(0, 0.5) == 20.5
