"""The findings of a proof, and whether they pass (pure)."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.commands.proof.measure import Sample
    from wax.commands.proof.watch import Sees

FRAME_LIMIT_MS: Final = 200.0
"""From the fault to the stop frame on the robot's line."""
ROBOT_LIMIT_MS: Final = 250.0
"""From the fault to standstill, plus the robot's braking time."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A link to cut. `ends` is what must stop the robot: a stop frame, or the robot itself."""

    key: str
    title: Sentence
    ends: Literal["frame", "robot"]


FAULTS: Final = (
    Fault("silent", Sentence("fault.silent"), "frame"),
    Fault("stop", Sentence("fault.stop"), "frame"),
    Fault("http", Sentence("fault.http"), "frame"),
    Fault("leave", Sentence("fault.leave"), "frame"),
    Fault("frozen", Sentence("fault.frozen"), "frame"),
    Fault("killed", Sentence("fault.killed"), "frame"),
    Fault("driver", Sentence("fault.driver"), "robot"),
    Fault("cut", Sentence("fault.cut"), "robot"),
)


def faults_of(sees: Sees) -> tuple[Fault, ...]:
    """Return the links to cut; only a robot on our serial line has one of that name."""
    if sees == "line":
        return FAULTS
    link = Sentence("fault.link")
    return tuple(replace(one, title=link) if one.key == "cut" else one for one in FAULTS)


@dataclass(frozen=True, slots=True)
class Finding:
    """One fault's samples; `skipped` is a sentence that says why it was not measured."""

    fault: Fault
    samples: tuple[Sample, ...] = ()
    skipped: str | None = None


@dataclass(frozen=True, slots=True)
class Findings:
    """The findings of a proof. `reports` is whether the robot reports if it moves.

    `braking_mps2` is from the configuration. `broken` is a sentence that says why it ended early.
    `sees` is where a stop counts as arrived.
    """

    findings: tuple[Finding, ...]
    repeats: int
    reports: bool
    braking_mps2: float
    broken: str | None = None
    sees: Sees = "line"

    @property
    def measured(self) -> tuple[Finding, ...]:
        return tuple(one for one in self.findings if one.skipped is None)

    @property
    def skipped(self) -> tuple[Finding, ...]:
        return tuple(one for one in self.findings if one.skipped is not None)

    @property
    def all_passed(self) -> bool:
        """Whether everything not skipped was measured completely and within the limits."""
        return (
            self.broken is None
            and bool(self.measured)
            and all(self.passed(finding) for finding in self.measured)
        )

    def passed(self, finding: Finding) -> bool:
        """Whether all samples are there and within the limits."""
        return len(finding.samples) >= self.repeats and all(
            self.sample_passed(finding.fault, sample) for sample in finding.samples
        )

    def sample_passed(self, fault: Fault, sample: Sample) -> bool:
        frame_ms, standing_ms = sample.frame_ms, sample.standing_ms
        if fault.ends == "frame" and (frame_ms is None or frame_ms > FRAME_LIMIT_MS):
            return False
        if not self.reports:
            return fault.ends == "frame"
        return standing_ms is not None and standing_ms <= self.standing_limit_ms(sample.speed_mps)

    def standing_limit_ms(self, speed_mps: float | None) -> float:
        """Return the limit to standstill from this speed."""
        return ROBOT_LIMIT_MS + (speed_mps or 0.0) / self.braking_mps2 * 1000.0

    @property
    def latest_ms(self) -> float | None:
        """The longest time to standstill, or to the stop frame if the robot does not report."""
        times = (
            sample.standing_ms if self.reports else sample.frame_ms
            for finding in self.findings
            for sample in finding.samples
        )
        return max((time for time in times if time is not None), default=None)

    @property
    def measured_braking_mps2(self) -> float | None:
        """The weakest braking after a stop frame; None if unknown."""
        rates = [
            sample.speed_mps / sample.braking_ms * 1000.0
            for finding in self.findings
            for sample in finding.samples
            if finding.fault.ends == "frame" and sample.speed_mps and sample.braking_ms
        ]
        return min(rates, default=None)


@dataclass(frozen=True, slots=True)
class StopSpread:
    """Median and maximum of the stops that came; `missing` of `n` did not come."""

    n: int
    missing: int
    median_ms: float | None
    max_ms: float | None


def spread(times_ms: Iterable[float | None]) -> StopSpread:
    """Summarise times; missing ones are counted separately."""
    times = list(times_ms)
    came = [time for time in times if time is not None]
    return StopSpread(
        n=len(times),
        missing=len(times) - len(came),
        median_ms=statistics.median(came) if came else None,
        max_ms=max(came, default=None),
    )
