"""The suite's arithmetic: a wrong figure in the report is worse than none."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

from e2e.harness.page_clock import unix_ms
from e2e.load.beside import Drive, crowd_rows
from e2e.load.cluster.driving import speeds_ms, sweep
from e2e.load.cluster.page import longest_gap_ms
from e2e.load.fan_out import Point, slope
from e2e.load.page import input_to_gate, work
from e2e.load.page.ways import WAYS
from e2e.load.strokes import Change, Stroke, changes, delays
from e2e.load.suite import SUITE
from e2e.measure.errors import MeasureError
from e2e.stop.imagined_record import record

if TYPE_CHECKING:
    from e2e.stop.record import Record

KEY, SIDEWAYS, STICK, PAD = WAYS


def frame(kind: str, left: int = 0, right: int = 0, verdict: str = "taken") -> dict[str, Any]:
    frame = {"event": "frame", "type": kind, "verdict": verdict, "turn": 1}
    return frame | {"left": left, "right": right}


def recorded(*log: dict[str, Any]) -> Record:
    """Record one event a second, from 0 s on."""
    return record(*(event | {"t_s": float(at_s)} for at_s, event in enumerate(log)))


def test_only_a_change_of_motion_counts() -> None:
    """Repeated and refused frames, a curve, a drive of zero and hello are no new start or stop."""
    start = [{"event": "plugged"}, frame("hello"), frame("stop"), frame("drive")]
    late, same = frame("drive", 9, 9, "late"), frame("drive", 9, 9)
    told = recorded(*start, late, same, same, frame("drive", 5, 9), frame("stop"), frame("stop"))
    assert changes(told.frames) == [Change(5000.0, moving=True), Change(8000.0, moving=False)]
    aside = frame("move") | {"linear": 0, "lateral": 9, "angular": 0}
    told = recorded(*start[:3], aside, frame("stop"))
    assert changes(told.frames) == [Change(3000.0, moving=True), Change(4000.0, moving=False)]


def test_each_stroke_is_answered_by_the_first_change_after_it() -> None:
    """Delays count from the key's own stroke; a stroke that moved nothing gets no effect."""
    strokes = [Stroke(True, 100.0), Stroke(False, 200.0), Stroke(True, 300.0)]
    moves = [Change(112.0, moving=True), Change(206.0, moving=False)]
    assert delays(strokes, moves, down=True) == [12.0]
    assert delays(strokes, moves, down=False) == [6.0]
    assert delays(strokes, [Change(310.0, moving=True)], down=True) == [10.0]
    assert delays(strokes, [Change(310.0, moving=True)], down=False) == []


def test_what_is_disturbed_or_saturated_has_no_part_in_the_slope() -> None:
    """If too few points are left, there is no slope."""

    def point(viewers: int, cpu: float, flaw: str | None = None, *, full: bool = False) -> Point:
        return Point(viewers, cpu, 0.0, 30.0, 0, full, flaw)

    good = [point(1, 0.11), point(11, 0.16)]
    bad = [point(20, 0.9, "others"), point(50, 0.95, full=True)]
    assert slope(good + bad) == pytest.approx(0.5)
    assert slope([good[0], point(2, 0.9, "others")]) is None


def test_the_price_of_a_crowd_is_what_it_adds() -> None:
    """It is taken pair by pair: a machine that warms up cancels out; the worst beat counts."""
    alone = [Drive([1.0, 5.0 + at], [60.0 + at]) for at in range(3)]
    beside = [Drive([1.0, 7.0 + at], [61.0 + at], 0, 2.0 + at, 9.0) for at in range(3)]
    found = crowd_rows(list(zip(alone, beside, strict=True)))
    assert [row.values["WAX"] for row in found] == [2.0, 1.0, 4.0, 9.0]


def stretches(*heaps_mib: float, percent: float = 4.0, fps: float = 30.0) -> list[work.Stretch]:
    long_ms = [80.0] if percent > 10 else []
    return [
        work.Stretch(1.0 + at, percent, long_ms, fps, heap) for at, heap in enumerate(heaps_mib)
    ]


def test_the_pages_work_is_the_worst_stretch_and_its_heap_the_second_half() -> None:
    """What fills at first is no leak; what keeps growing is one, over the whole time."""
    flat = stretches(2, 4, 6, 8, 8, 8, 8, 8)
    share, long, heap = work.rows(flat, flat)
    assert (share.met, long.met, heap.met) == (True, True, True)
    assert heap.values["WAX"] == pytest.approx(0.0)
    share, long, heap = work.rows(
        flat[:4] + stretches(8.0, 8.2, 8.4, 8.6, percent=12.0), stretches(1, percent=1.0)
    )
    assert (share.values, share.met) == ({"WAX": 12.0, "stock aiortc": 1.0}, False)
    assert (long.values["WAX"], long.met) == (4.0, False)
    with pytest.raises(MeasureError, match="not 30"):
        work.rows(stretches(1, 1, 1, 1, fps=20.0), flat)
    with pytest.raises(MeasureError, match="too few"):
        work.rows(flat[:3], flat)


def test_a_press_begins_with_the_ways_own_event() -> None:
    """A joystick's press begins with the first push, not the finger; a key's with its own key."""
    noted: list[list[Any]] = [
        ["pointerdown", "", 1.0, 1.5],
        ["pointermove", "", 2.0, 2.25],
        ["pointermove", "", 3.0, 9.0],
        ["pointerup", "", 4.0, 4.5],
        ["keydown", "Tab", 5.0, 5.5],
        ["keydown", "ArrowUp", 6.0, 6.5],
        ["keyup", "Tab", 7.0, 7.5],
        ["keyup", "ArrowUp", 8.0, 8.5],
        ["paddown", "", 9.0, 9.0],
        ["padup", "", 10.0, 10.0],
    ]
    assert STICK.strokes(noted) == [Stroke(True, 2.0), Stroke(False, 4.0)]
    assert STICK.told_after_ms(noted) == [0.25]
    assert KEY.strokes(noted) == [Stroke(True, 6.0), Stroke(False, 8.0)]
    assert PAD.strokes(noted) == [Stroke(True, 9.0), Stroke(False, 10.0)]


def test_presses_without_effect_are_told() -> None:
    """A few presses may have no effect; the others' delays count."""
    strokes = [
        Stroke(down, 1000.0 * at + (0 if down else 300))
        for at in range(40)
        for down in (True, False)
    ]
    moves = [Change(stroke.made_ms + 8, stroke.down) for stroke in strokes]
    press, release = input_to_gate.rows(KEY, strokes, moves[:-2], 0.1)
    assert (press.n, press.values["p99"], press.met) == (39, 8.0, True)
    assert press.detail["unanswered"] == 1
    assert (release.n, release.met) == (39, True)
    with pytest.raises(MeasureError, match="of 40 presses 20"):
        input_to_gate.rows(KEY, strokes, moves[:40], 0.1)


def test_a_gap_is_counted_from_before_its_edge() -> None:
    """A picture shown before the fault counts from its start; the next one ends the gap."""
    shown_ms = [0.0, 30.0, 60.0, 900.0, 930.0]
    assert longest_gap_ms(shown_ms, 100.0, 500.0) == 840.0
    assert longest_gap_ms(shown_ms, 10.0, 50.0) == 30.0
    for from_ms, to_ms in ((-1.0, 50.0), (100.0, 931.0)):
        with pytest.raises(MeasureError):
            longest_gap_ms(shown_ms, from_ms, to_ms)


def test_each_command_beside_a_fault_has_another_speed() -> None:
    """A repeated speed is no new command."""
    assert all(abs(a - b) > 0.004 for a, b in pairwise(map(sweep, range(1000))))
    drive = [frame("drive", speed, -speed) for speed in (5, 5, 6)]
    late, stop = frame("drive", 9, -9, "late"), frame("stop")
    frames = recorded(stop, *drive, late, stop, stop, drive[-1]).frames
    told_ms = [at_ms - unix_ms(0.0) for at_ms in speeds_ms(frames)]
    assert told_ms == pytest.approx([0, 1000, 3000, 5000, 7000], abs=100)


def test_cases_have_names_of_their_own() -> None:
    """Cases that take half an hour are not published."""
    keys = [case.key for case in SUITE.cases]
    assert len(set(keys)) == len(keys)
    assert sum(case.minutes for case in SUITE.cases if not case.long) <= 22
