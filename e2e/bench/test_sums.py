"""The benchmark's arithmetic: a figure that is wrong in the report is worse than none."""

from __future__ import annotations

import pytest

from e2e.bench.errors import BenchError
from e2e.bench.key_to_byte import Stroke, delays
from e2e.bench.motion import Change, changes
from e2e.bench.serial_line import Piece
from e2e.bench.spread import spread
from wax.robot.serial.frames import Body, Drive, Frame, Hello, Stop, encode


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
    """Repeated frames, a curve, a drive of zero and the greeting are no new start or stop."""
    bodies: list[Body] = [
        Hello(),
        Stop(),
        Drive(0, 0),
        Drive(9, 9),
        Drive(9, 9),
        Drive(5, 9),
        Stop(),
        Stop(),
    ]
    pieces = [Piece(float(at_ms), encode(Frame(body))) for at_ms, body in enumerate(bodies)]
    assert changes(pieces) == [Change(3.0, moving=True), Change(6.0, moving=False)]


def test_a_frame_in_two_pieces_counts_when_it_is_whole() -> None:
    """A board cannot act on half a frame, so the second half's time is taken."""
    data = encode(Frame(Drive(9, 9)))
    assert changes([Piece(1.0, data[:7]), Piece(2.0, data[7:])]) == [Change(2.0, moving=True)]


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
