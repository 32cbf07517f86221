"""Measurements on invented logs of frames."""

from __future__ import annotations

import pytest

from wax.commands.proof.measure import Event, Sample, measure


def said(at_s: float, speed_mps: float) -> Event:
    return Event(at_s, "said", speed_mps > 0, speed_mps)


def told(at_s: float, *, moves: bool) -> Event:
    return Event(at_s, "told", moves)


DRIVES = [said(9.96, 0.18), told(9.97, moves=True), said(9.98, 0.18)]


def rounded(sample: Sample) -> tuple[float | None, float | None]:
    times = (sample.frame_ms, sample.standing_ms)
    frame_ms, standing_ms = (None if time is None else round(time, 3) for time in times)
    return frame_ms, standing_ms


def test_both_times_count_from_the_fault() -> None:
    """The stop frame and the report of standstill are measured from the instant of the fault."""
    log = [*DRIVES, said(10.02, 0.18), said(10.15, 0.0), told(10.16, moves=True)]
    log += [said(10.2, 0.0), told(10.24, moves=False), told(10.3, moves=False)]
    sample = measure(log, 10.0)
    assert rounded(sample) == (150.0, 240.0)
    assert sample.braking_ms == pytest.approx(90.0)
    assert sample.speed_mps == 0.18


def test_a_stop_that_does_not_last_is_none() -> None:
    """Only the stop frame, and the report, after which no motion follows count."""
    log = [*DRIVES, said(10.05, 0.0), told(10.1, moves=False), said(10.2, 0.18)]
    log += [told(10.22, moves=True), said(10.4, 0.0), told(10.5, moves=False)]
    assert rounded(measure(log, 10.0)) == (400.0, 500.0)


@pytest.mark.parametrize(
    "after",
    [
        [],
        [said(10.02, 0.18), told(10.03, moves=True)],
        [said(10.02, 0.0), said(10.5, 0.18), told(10.03, moves=False), told(10.6, moves=True)],
    ],
    ids=["silence", "drives on", "stops and drives on"],
)
def test_what_does_not_come_is_none(after: list[Event]) -> None:
    """Without a lasting stop there is no time; neither silence nor an earlier stop counts."""
    log = [said(9.9, 0.0), told(9.91, moves=False), *DRIVES, *after]
    assert rounded(measure(log, 10.0)) == (None, None)


def test_a_robot_that_stands_before_the_frame_has_not_braked_a_negative_time() -> None:
    """If the robot's watchdog stops it before the frame, its braking time is zero."""
    log = [*DRIVES, told(10.2, moves=False), said(10.25, 0.0)]
    assert measure(log, 10.0).braking_ms == 0.0


@pytest.mark.parametrize("times_ms", [(None, 240.0), (150.0, None)])
def test_there_is_no_braking_without_both_ends(times_ms: tuple[float | None, float | None]) -> None:
    """Without a frame or a report, the braking time is unknown."""
    assert Sample(*times_ms, speed_mps=0.18).braking_ms is None


def test_what_comes_with_the_fault_comes_after_it() -> None:
    """A frame at the very time of the fault counts as after it."""
    sample = measure([*DRIVES, said(10.0, 0.0)], 10.0)
    assert (sample.frame_ms, sample.speed_mps) == (0.0, 0.18)


def test_the_speed_is_that_before_the_fault() -> None:
    """The speed is the one requested before the fault, whatever is requested after."""
    drives = [*DRIVES, told(9.99, moves=True)]
    assert measure([*drives, said(10.01, 0.6), said(10.1, 0.0)], 10.0).speed_mps == 0.18
    assert measure([said(10.01, 0.6)], 10.0).speed_mps is None
