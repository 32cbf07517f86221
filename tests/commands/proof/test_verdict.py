"""Which findings pass."""

from __future__ import annotations

import pytest

from wax.commands.proof.measure import Sample
from wax.commands.proof.verdict import FAULTS, Fault, Finding, Findings, faults_of, spread

BY_FRAME = next(fault for fault in FAULTS if fault.ends == "frame")
BY_ROBOT = next(fault for fault in FAULTS if fault.ends == "robot")
GOOD = Sample(frame_ms=180.0, standing_ms=270.0, speed_mps=0.18)


def found(
    *samples: Sample,
    fault: Fault = BY_FRAME,
    repeats: int = 1,
    reports: bool = True,
    skipped: str | None = None,
    broken: str | None = None,
) -> Findings:
    finding = Finding(fault, samples, skipped)
    return Findings((finding,), repeats, reports, braking_mps2=2.0, broken=broken)


@pytest.mark.parametrize(
    ("fault", "sample", "passes"),
    [
        (BY_FRAME, GOOD, True),
        (BY_FRAME, Sample(200.0, 340.0, 0.18), True),
        (BY_FRAME, Sample(200.1, 270.0, 0.18), False),
        (BY_FRAME, Sample(180.0, 340.05, 0.18), False),
        (BY_FRAME, Sample(None, 270.0, 0.18), False),
        (BY_FRAME, Sample(180.0, None, 0.18), False),
        (BY_ROBOT, Sample(None, 340.0, 0.18), True),
        (BY_ROBOT, Sample(700.0, 340.0, 0.18), True),
        (BY_ROBOT, Sample(None, 340.05, 0.18), False),
        (BY_ROBOT, Sample(None, None, 0.18), False),
        (BY_ROBOT, Sample(None, 250.1, None), False),
    ],
)
def test_a_sample_passes_within_its_limits(fault: Fault, sample: Sample, *, passes: bool) -> None:
    """The frame has 200 ms, the robot 250 and its braking from its speed: 90 ms of 0.18 m/s."""
    assert found(sample, fault=fault).all_passed is passes


def test_one_late_sample_fails_the_proof() -> None:
    """One late sample fails the proof: the maximum counts, not the median."""
    late = Sample(frame_ms=400.0, standing_ms=490.0, speed_mps=0.18)
    assert found(GOOD, GOOD, GOOD, repeats=3).all_passed
    assert not found(GOOD, late, GOOD, repeats=3).all_passed


def test_one_late_link_fails_the_proof() -> None:
    """One late link fails the proof, even if all others pass."""
    late = Finding(BY_ROBOT, (Sample(None, None, 0.18),))
    both = Findings((Finding(BY_FRAME, (GOOD,)), late), 1, reports=True, braking_mps2=2.0)
    assert not both.all_passed


def test_what_was_not_finished_is_not_passed() -> None:
    """Missing samples, an early end and no samples at all fail."""
    assert not found(GOOD, repeats=2).all_passed
    assert not found(GOOD, broken="it was aborted.").all_passed
    assert not found(skipped="no such part").all_passed


def test_what_was_skipped_is_no_part_of_the_verdict() -> None:
    """A skipped link neither passes nor fails, and stays named."""
    passed, skipped = Finding(BY_FRAME, (GOOD,)), Finding(BY_ROBOT, skipped="no such part")
    both = Findings((passed, skipped), repeats=1, reports=True, braking_mps2=2.0)
    assert both.all_passed
    assert (both.measured, both.skipped) == ((passed,), (skipped,))


def test_a_robot_that_does_not_report_is_judged_by_the_frame_alone() -> None:
    """Without reports a fault that only the robot can end is never passed."""
    silent = Sample(frame_ms=180.0, standing_ms=None, speed_mps=None)
    assert found(silent, reports=False).all_passed
    assert not found(Sample(None, None, None), reports=False).all_passed
    assert not found(silent, fault=BY_ROBOT, reports=False).all_passed


def test_the_latest_is_the_longest_that_came() -> None:
    """The time in the record's sentence is the worst of all samples."""
    slower = Sample(frame_ms=190.0, standing_ms=300.0, speed_mps=0.18)
    assert found(GOOD, slower, GOOD, repeats=3).latest_ms == 300.0
    assert found(GOOD, slower, repeats=2, reports=False).latest_ms == 190.0
    assert found(Sample(None, None, 0.18)).latest_ms is None


def test_braking_is_measured_from_the_frame() -> None:
    """0.18 m/s in 90 ms is 2 m/s²; the worst sample is what the configuration may promise."""
    worse = Sample(frame_ms=100.0, standing_ms=280.0, speed_mps=0.18)
    assert found(GOOD).measured_braking_mps2 == pytest.approx(2.0)
    assert found(GOOD, worse).measured_braking_mps2 == pytest.approx(1.0)
    assert found(Sample(None, 300.0, 0.18)).measured_braking_mps2 is None
    assert found(Sample(180.0, 270.0, None)).measured_braking_mps2 is None


def test_braking_that_no_frame_began_is_not_measured() -> None:
    """If the robot stops by itself before a frame, its braking is not measured."""
    assert found(GOOD, fault=BY_ROBOT).measured_braking_mps2 is None


def test_only_a_line_is_called_a_cable() -> None:
    """Every robot has the same faults, but only a link on our serial line is called a cable."""
    assert faults_of("line") == FAULTS
    others = faults_of("driver")
    assert [(one.key, one.ends) for one in others] == [(one.key, one.ends) for one in FAULTS]
    assert [one.title.code for one in others if one not in FAULTS] == ["fault.link"]


def test_a_spread_counts_what_did_not_come() -> None:
    """Median and maximum are of the stops that came, and missing ones are counted."""
    times = spread([30.0, None, 10.0, 20.0])
    assert (times.n, times.missing, times.median_ms, times.max_ms) == (4, 1, 20.0, 30.0)
    assert spread([None]).median_ms is None
