"""When a set-point is sent."""

from __future__ import annotations

from wax.driver.interface import STANDSTILL, Twist
from wax.robot.mavlink.schedule import NEUTRAL_EVERY_S, STEADY_S, Schedule

AHEAD, FASTER = Twist(0.3, 0.0), Twist(0.4, 0.0)
GAP_S = 0.02


def said(schedule: Schedule, wanted: Twist, from_s: float, to_s: float) -> list[float]:
    """Send whenever due; return the times."""
    times_s, now_s = [], from_s
    while (now_s := schedule.next_s(wanted, now_s)) < to_s:
        schedule.said(wanted, now_s)
        times_s.append(now_s)
    return times_s


def test_motion_is_sent_steadily() -> None:
    """Motion is sent at once, then once a gap."""
    schedule = Schedule(GAP_S)
    times_s = said(schedule, AHEAD, 100.0, 101.0)
    assert times_s[0] == 100.0
    assert 49 <= len(times_s) <= 51


def test_a_change_waits_for_the_gap_and_a_stop_does_not() -> None:
    """A slow line is not filled, and a stop is never late."""
    schedule = Schedule(GAP_S)
    schedule.said(AHEAD, 100.0)
    assert schedule.next_s(FASTER, 100.001) == 100.0 + GAP_S
    assert schedule.next_s(STANDSTILL, 100.001) == 100.001


def test_motion_begins_between_two_repeats_of_standstill() -> None:
    """New motion does not wait for a repeat; further changes wait for the gap."""
    schedule = Schedule(GAP_S)
    schedule.said(AHEAD, 100.0)
    times_s = said(schedule, STANDSTILL, 100.0, 100.2)
    pressed_s = times_s[-1] + 0.001
    assert schedule.next_s(AHEAD, pressed_s) == pressed_s
    schedule.said(AHEAD, pressed_s)
    assert schedule.next_s(AHEAD, pressed_s) == pressed_s + GAP_S
    assert schedule.next_s(FASTER, pressed_s + 0.001) == pressed_s + GAP_S


def test_changes_that_follow_each_repeat_do_not_fill_the_line() -> None:
    """A constantly moving stick sends one set-point a gap, whatever its phase."""
    schedule = Schedule(GAP_S)
    schedule.said(AHEAD, 100.0)
    (*_, repeat_s) = said(schedule, AHEAD, 100.0, 100.1)
    assert schedule.next_s(FASTER, repeat_s + 0.001) == repeat_s + GAP_S


def test_standstill_after_motion_is_steady_and_then_slow() -> None:
    """Standstill is sent steadily for more than 1.5 s, then slowly for ever."""
    schedule = Schedule(GAP_S)
    schedule.said(AHEAD, 100.0)
    times_s = said(schedule, STANDSTILL, 100.0, 110.0)
    steady = [at_s for at_s in times_s if at_s < 100.0 + STEADY_S]
    slow = [at_s for at_s in times_s if at_s > 100.0 + STEADY_S + NEUTRAL_EVERY_S]
    assert STEADY_S > 1.5
    assert len(steady) >= STEADY_S / GAP_S - 2
    assert len(slow) >= 7.0 / NEUTRAL_EVERY_S - 1


def test_a_stop_of_a_standing_robot_is_sent_again() -> None:
    """Each stop is sent at once and then steadily."""
    schedule = Schedule(GAP_S)
    said(schedule, STANDSTILL, 100.0, 105.0)
    schedule.stopped(105.1)
    assert schedule.next_s(STANDSTILL, 105.1) == 105.1
    assert len(said(schedule, STANDSTILL, 105.1, 106.0)) > 40
