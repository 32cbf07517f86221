"""The suite's arithmetic: a figure that is wrong in the report is worse than none."""

from __future__ import annotations

from typing import Any

import pytest

from e2e.load.key_to_byte import Change, Stroke
from e2e.load.page import input_to_gate, main_thread, memory, presented
from e2e.load.page.main_thread import Stretch, share_percent
from e2e.load.page.memory import Reading
from e2e.load.page.suite import SUITE
from e2e.load.page.ways import WAYS
from e2e.measure.errors import MeasureError

KEY, BUTTON, STICK, PAD, STEP = WAYS


def test_the_share_is_of_the_time_that_passed() -> None:
    """By the browser's own clock: 1.5 s of tasks in 30 s are 5 %."""
    before = {"Timestamp": 100.0, "TaskDuration": 7.0}
    after = {"Timestamp": 130.0, "TaskDuration": 8.5}
    assert share_percent(before, after) == pytest.approx(5.0)


def test_long_tasks_are_counted_over_all_stretches() -> None:
    """One of them misses the goal, and so does one stretch that takes too much."""
    calm, busy = Stretch(4.0, [], 30.0), Stretch(12.0, [51.0, 80.0], 29.5)
    share, stock, long = main_thread.rows([calm, calm], [calm])
    assert (share.met, long.met, stock.met) == (True, True, None)
    share, _, long = main_thread.rows([calm, busy], [calm])
    assert (share.met, share.values["max"]) == (False, 12.0)
    assert (long.met, long.values["max"], long.detail["longest_ms"]) == (False, 2.0, 80.0)


def test_work_at_fewer_pictures_is_no_figure() -> None:
    """A page that is shown 20 pictures a second works less, and says nothing of 30."""
    with pytest.raises(MeasureError, match="not 30"):
        main_thread.rows([Stretch(4.0, [], 20.0)], [Stretch(1.0, [], 30.0)])


def _readings(*heaps_mib: float) -> list[Reading]:
    return [Reading(float(at), heap, 100.0, 10.0) for at, heap in enumerate(heaps_mib)]


def test_memory_is_the_slope_of_the_second_half() -> None:
    """What fills at first is no leak; what goes on growing is one, over the whole time."""
    (flat,) = memory.rows(_readings(2, 4, 6, 8, 8, 8, 8, 8), 30)
    assert flat.values["median"] == pytest.approx(0.0)
    assert flat.met
    (leak,) = memory.rows(_readings(8, 8, 8, 8, 8.0, 8.1, 8.2, 8.3), 30)
    assert leak.values["median"] == pytest.approx(3.0)
    assert leak.met is False
    with pytest.raises(MeasureError, match="too few"):
        memory.rows(_readings(1, 1, 1), 30)


def test_pictures_are_compared_pair_by_pair() -> None:
    """So that a machine that slows down slows both; too few of a bare video say nothing."""
    (row,) = presented.rows([(29.9, 30.0), (14.9 * 2, 30.0), (26.9, 27.0)])
    assert row.values["median"] == pytest.approx(99.63, abs=0.01)
    assert row.met
    (row,) = presented.rows([(20.0, 30.0)])
    assert row.met is False
    with pytest.raises(MeasureError, match="not 30"):
        presented.rows([(10.0, 10.0)])


def test_a_press_begins_with_the_ways_own_event() -> None:
    """A joystick's with the first push, not with the finger; a key's not with another key."""
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
    assert BUTTON.strokes(noted) == [Stroke(True, 1.0), Stroke(False, 4.0)]
    assert PAD.strokes(noted) == [Stroke(True, 9.0), Stroke(False, 10.0)]


def test_presses_without_effect_are_told() -> None:
    """A few are, and the others' delays count; with many of them there is no figure."""
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


def test_a_step_stops_by_itself() -> None:
    """So that only its beginning has a delay."""
    strokes = [Stroke(True, 0.0), Stroke(False, 100.0)]
    (row,) = input_to_gate.rows(STEP, strokes, [Change(9.0, True), Change(400.0, False)], 0.1)
    assert row.key == "input/step"


def test_cases_have_names_of_their_own() -> None:
    """Each way of input is a case, and n is as large as a p99 needs."""
    keys = [case.key for case in SUITE.cases]
    assert len(set(keys)) == len(keys)
    inputs = [case for case in SUITE.cases if case.key.startswith("input/")]
    assert len(inputs) == len(WAYS)
    assert all(case.n >= 200 for case in inputs)
