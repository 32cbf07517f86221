"""The schedule of the ticks, and how late they were."""

from __future__ import annotations

import pytest

from wax.control.loop_timer import BOUNDS_MS, Lateness, LoopTimer


def test_schedule_does_not_drift() -> None:
    """However late a tick is, the next ones stay on schedule."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    assert beat.rest_s(10.0) == 0.0
    assert not beat.is_too_late(10.0)
    assert beat.rest_s(10.0) == pytest.approx(0.02)
    assert not beat.is_too_late(10.055)
    assert beat.rest_s(10.055) == pytest.approx(0.005)
    assert beat.rest_s(10.07) == 0.0


def test_a_step_between_two_beats_is_not_late() -> None:
    """A step between two ticks changes neither the schedule nor the record."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    beat.is_too_late(10.0)
    assert not beat.is_too_late(10.015)
    assert beat.rest_s(10.015) == pytest.approx(0.005)
    beat.is_too_late(10.02 + 0.003)
    assert beat.latest_ms == pytest.approx(3.0)


def test_every_tick_is_in_the_histogram() -> None:
    """The histogram counts an early tick as not late, and no step between two ticks."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    for now_s in (10.0, 10.015, 10.0195, 10.043):
        beat.is_too_late(now_s)
    assert sum(beat.lateness.counts) == 3
    assert beat.lateness.sum_s == pytest.approx(0.003)


def test_ticks_that_never_came_were_late() -> None:
    """Skipped ticks count as late: fifty for a second's stall, at most a minute's worth in all."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    for number in range(300):
        beat.is_too_late(number / 50)
    beat.is_too_late(7.0 - 0.02)
    assert beat.latest_ms == pytest.approx(980.0)
    assert beat.jitter_p99_ms == pytest.approx(920.0)
    beat.is_too_late(86_400.0)
    assert beat.jitter_p99_ms > 86_000_000.0


def test_a_timer_that_fires_early_is_no_second_beat() -> None:
    """A step just before its tick counts as that tick, and is not followed by another at once."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    beat.is_too_late(10.0)
    beat.is_too_late(10.0195)
    assert beat.rest_s(10.0195) == pytest.approx(0.0205)
    assert beat.latest_ms == 0.0


def test_early_is_a_millisecond_at_most() -> None:
    """A step up to 1 ms before a tick counts as that tick; an earlier one is between two ticks."""
    for early_s, rest_s in ((0.001, 0.021), (0.0011, 0.0011)):
        beat = LoopTimer(loop_hz=50.0, ttl_s=None)
        beat.is_too_late(-0.02)  # so that the next is due at 0, where no number is rounded
        beat.is_too_late(-early_s)
        assert beat.rest_s(-early_s) == pytest.approx(rest_s)


@pytest.mark.parametrize(
    ("ttl_s", "let_be_s"), [(None, 0.2), (1.0, 0.2), (0.15, 0.15), (0.02, 0.1)]
)
def test_too_late(ttl_s: float | None, let_be_s: float) -> None:
    """A tick may be as late as the robot's own timeout, but no less than 100 and at most 200 ms."""
    for late_s, expected in ((let_be_s - 0.001, False), (let_be_s + 0.001, True)):
        beat = LoopTimer(loop_hz=50.0, ttl_s=ttl_s)
        beat.is_too_late(10.0)
        assert beat.is_too_late(10.02 + late_s) is expected


def test_as_late_as_it_may_be_is_not_too_late() -> None:
    """A tick exactly as late as allowed is not too late."""
    beat = LoopTimer(loop_hz=5.0, ttl_s=None)
    beat.is_too_late(0.0)
    assert not beat.is_too_late(0.4)


def test_record_of_the_last_minute() -> None:
    """The record gives the 99th percentile and the maximum lateness of the last minute."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    assert (beat.jitter_p99_ms, beat.latest_ms) == (0.0, 0.0)
    for number in range(3000):
        beat.is_too_late(10 + number / 50 + (0.019 if number == 7 else number % 100 * 1e-5))
    assert beat.latest_ms == pytest.approx(19.0)
    assert beat.jitter_p99_ms == pytest.approx(0.99)
    for number in range(3000, 6000):
        beat.is_too_late(10 + number / 50 + 0.001)
    assert beat.latest_ms == pytest.approx(1.0)


@pytest.mark.parametrize(("loop_hz", "beats"), [(20.0, 1200), (20.01, 1201)])
def test_the_record_is_of_one_minute(loop_hz: float, beats: int) -> None:
    """A late tick is kept for as many ticks as a minute has."""
    beat = LoopTimer(loop_hz=loop_hz, ttl_s=None)
    beat.is_too_late(0.0)
    now_s = beat.rest_s(0.0) + 0.03
    beat.is_too_late(now_s)
    for _ in range(beats - 1):
        now_s += beat.rest_s(now_s)
        beat.is_too_late(now_s)
    assert beat.latest_ms == pytest.approx(30.0)
    beat.is_too_late(now_s + beat.rest_s(now_s))
    assert beat.latest_ms == pytest.approx(0.0, abs=1e-6)


def test_of_few_beats_the_latest_counts() -> None:
    """With fewer than a hundred ticks the percentile is the maximum."""
    beat = LoopTimer(loop_hz=50.0, ttl_s=None)
    beat.is_too_late(10.0)
    beat.is_too_late(10.025)
    assert beat.jitter_p99_ms == pytest.approx(5.0)


def test_lateness_falls_into_its_bucket() -> None:
    """Each bucket includes its bound, and the last one counts everything beyond."""
    lateness = Lateness()
    for bound_ms in BOUNDS_MS:
        lateness.add(bound_ms / 1000)
    lateness.add(10.0)
    assert lateness.counts == [1] * (len(BOUNDS_MS) + 1)
    assert BOUNDS_MS == (0.5, 1, 2, 5, 10, 20, 40, 100, 200), "dashboards name these bounds"
    assert lateness.sum_s == pytest.approx(sum(BOUNDS_MS) / 1000 + 10)
