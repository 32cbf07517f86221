"""The benchmark's arithmetic: a figure that is wrong in the report is worse than none."""

from __future__ import annotations

from typing import Any

import pytest

from e2e.bench.errors import BenchError
from e2e.bench.key_to_byte import Stroke, delays
from e2e.bench.motion import Change, changes
from e2e.bench.spread import spread


def test_quantiles_are_of_the_values_that_were_measured() -> None:
    """Of 1…200 the median is 100.5, and p99 is the 198th, not something between."""
    found = spread([float(value) for value in range(200, 0, -1)])
    assert (found.n, found.min, found.max) == (200, 1, 200)
    assert (found.p50, found.p95, found.p99) == (100.5, 190, 198)


def test_nothing_measured_is_said_and_not_summed_up() -> None:
    """An empty measurement is an error, never a row of zeros."""
    with pytest.raises(BenchError):
        spread([])


def test_only_a_change_of_motion_counts() -> None:
    """Repeated and refused frames, a curve, a drive of zero and hello are no new start or stop."""

    def frame(kind: str, left: int = 0, right: int = 0, verdict: str = "taken") -> dict[str, Any]:
        frame = {"event": "frame", "type": kind, "verdict": verdict}
        return frame | {"left": left, "right": right}

    log = [
        {"event": "plugged"},
        frame("hello"),
        frame("stop"),
        frame("drive"),
        frame("drive", 9, 9, "late"),
        frame("drive", 9, 9),
        frame("drive", 9, 9),
        frame("drive", 5, 9),
        frame("stop"),
        frame("stop"),
    ]
    timed = [event | {"t_s": float(at_s)} for at_s, event in enumerate(log)]
    assert changes(timed) == [Change(5000.0, moving=True), Change(8000.0, moving=False)]


def test_each_stroke_is_answered_by_the_first_change_after_it() -> None:
    """Delays run from the key's own stroke, both from its making and from its handling."""
    strokes = [Stroke(True, 100.0, 101.0), Stroke(False, 200.0, 203.0)]
    moves = [Change(112.0, moving=True), Change(206.0, moving=False)]
    assert delays(strokes, moves, down=True) == [(12.0, 11.0)]
    assert delays(strokes, moves, down=False) == [(6.0, 3.0)]


def test_a_stroke_without_effect_is_not_lent_the_next_ones() -> None:
    """A press that moved nothing stays unanswered when the press after it does move."""
    strokes = [
        Stroke(True, 100.0, 100.0),
        Stroke(False, 200.0, 200.0),
        Stroke(True, 300.0, 300.0),
    ]
    moves = [Change(310.0, moving=True)]
    assert delays(strokes, moves, down=True) == [(10.0, 10.0)]
    assert delays(strokes, moves, down=False) == []
