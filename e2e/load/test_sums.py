"""The benchmark's arithmetic: a figure that is wrong in the report is worse than none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from e2e.load import cameras
from e2e.load.cameras import Stretch
from e2e.load.crossing import Watch
from e2e.load.crossing import rows_of as crossing_rows
from e2e.load.key_to_byte import Change, Stroke, changes, delays
from e2e.load.picture_cost import Cost, per_picture, row_of
from e2e.load.recording import Drive, rows_of
from e2e.measure.errors import MeasureError
from e2e.stop.record import Record


def test_only_a_change_of_motion_counts() -> None:
    """Repeated and refused frames, a curve, a drive of zero and hello are no new start or stop."""

    def frame(kind: str, left: int = 0, right: int = 0, verdict: str = "taken") -> dict[str, Any]:
        frame = {"event": "frame", "type": kind, "verdict": verdict, "turn": 1}
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
    record = Record(Path("unread"))
    record.take(timed)
    assert changes(record.frames) == [Change(5000.0, moving=True), Change(8000.0, moving=False)]


def test_each_stroke_is_answered_by_the_first_change_after_it() -> None:
    """Delays run from the key's own stroke."""
    strokes = [Stroke(True, 100.0), Stroke(False, 200.0)]
    moves = [Change(112.0, moving=True), Change(206.0, moving=False)]
    assert delays(strokes, moves, down=True) == [12.0]
    assert delays(strokes, moves, down=False) == [6.0]


def test_a_stroke_without_effect_is_not_lent_the_next_ones() -> None:
    """A press that moved nothing stays unanswered when the press after it does move."""
    strokes = [
        Stroke(True, 100.0),
        Stroke(False, 200.0),
        Stroke(True, 300.0),
    ]
    moves = [Change(310.0, moving=True)]
    assert delays(strokes, moves, down=True) == [10.0]
    assert delays(strokes, moves, down=False) == []


def test_the_price_of_the_tape_is_what_it_adds() -> None:
    """CPU pair by pair, so that a machine that warms up cancels out; commands over all strokes."""
    off = [Drive(cpu, [1.0, worst_ms], 0) for cpu, worst_ms in ((0.3, 5.0), (0.4, 5.0))]
    on = [Drive(cpu, [1.0, worst_ms], 3) for cpu, worst_ms in ((0.32, 8.0), (0.44, 7.0))]
    cpu, command, left_out = rows_of(off, on)
    assert cpu.values["WAX"] == pytest.approx(3.0)
    assert command.values["WAX"] == pytest.approx(3.0)
    assert command.met is False
    assert left_out.values["WAX"] == 6


def test_the_price_of_a_second_camera_is_the_pairs() -> None:
    """What it adds in the median pair; on the thin line, what the driving view never had alone."""

    def stretch(age_ms: float, *renditions: str) -> Stretch:
        return Stretch([age_ms - 5, age_ms, age_ms + 50], list(renditions), 640)

    wide = [(stretch(20), stretch(20 + more)) for more in (1.0, 9.0, 2.0)]
    thin = [(stretch(90, "b", "c"), stretch(90, "b", "a", "b"))]
    age, rendition = cameras.rows_of(wide, thin)
    assert (age.values["WAX"], age.met, age.n) == (2.0, True, 3)
    assert (rendition.values["WAX"], rendition.met, rendition.n) == (1.0, False, 3)


def test_what_the_crossing_adds_is_the_difference() -> None:
    """Age by the slowest hundredth, CPU by the median round; more than the goal is not met."""
    inside, across = Watch([1.0] * 200, [0.2, 0.3, 0.9]), Watch([1.5] * 200, [0.5, 0.7, 0.8])
    age, cpu = crossing_rows((640, 480), inside, across)
    assert (age.values, age.met, age.n) == ({"WAX": 0.5}, True, 200)
    assert cpu.values["WAX"] == pytest.approx(0.4)
    slow, _ = crossing_rows((1280, 720), inside, Watch([9.0] * 200, [0.5]))
    assert slow.met is False


def test_a_picture_costs_its_share_of_the_windows() -> None:
    """The median window is told, with its share of a core; a window without any is no result."""
    costs = per_picture([(0.3, 30), (0.6, 30), (0.45, 30)])
    assert costs == pytest.approx([10.0, 20.0, 15.0])
    row = row_of(640, 480, "vp8", Cost([1.0, 1.0], costs, 30.0), 90)
    assert row.values == pytest.approx({"WAX": 15.0})
    assert row.detail["share"] == pytest.approx(0.45)
    assert (row.met, row.n) == (None, 90)
    with pytest.raises(MeasureError, match="without a picture"):
        per_picture([(0.3, 30), (0.1, 0)])
