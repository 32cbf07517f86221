"""The suite's own arithmetic on a board's log."""

from __future__ import annotations

import math
from typing import Any

import pytest

from e2e.stop.hand_over import switches
from e2e.stop.imagined_record import record
from e2e.stop.nuisance import halts


def frame(at_s: float, kind: str = "drive", *, speed: int = 100, turn: int = 1) -> dict[str, Any]:
    speed = speed if kind == "drive" else 0
    said = {"t_s": at_s, "event": "frame", "type": kind, "verdict": "taken", "turn": turn}
    return said | {"left": speed, "right": speed}


def wheels(at_s: float, speed: int) -> dict[str, Any]:
    return {"t_s": at_s, "event": "wheels", "left": speed, "right": speed}


def test_a_stop_is_timed_to_its_first_frame() -> None:
    """The first frame that stops counts, not a later one."""
    seen = record(
        frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), wheels(1.15, 0), frame(1.2, "stop")
    )
    stopping = seen.stopping(1.05, 2.0)
    assert seen.moved_at(1.05)
    assert stopping.told_ms == stopping.ends_ms == pytest.approx(50)
    assert stopping.by_itself_ms is None
    assert stopping.moved_again_ms == []


def test_the_way_to_standstill_is_never_too_short() -> None:
    """The faster wheel counts, in either direction, and for each span the faster of its ends."""
    seen = record(frame(1.0), wheels(1.0, 600), frame(1.1, "stop"), wheels(1.1, 580))
    assert seen.stopping(1.05, 2.0).travelled_mm is None
    seen.take([wheels(1.13, 0), wheels(1.5, 300), wheels(1.6, 0)])
    assert seen.stopping(1.05, 2.0).travelled_mm == pytest.approx(600 * 0.05 + 580 * 0.03)
    assert seen.stopping(1.05, 1.12).travelled_mm is None
    curve = {"t_s": 1.0, "event": "wheels", "left": 100, "right": -400}
    turning = record(frame(1.0), curve, wheels(1.2, 0))
    assert turning.stopping(1.1, 2.0).travelled_mm == pytest.approx(40)


def test_motion_sideways_is_motion() -> None:
    """A move moves by each of its parts, and the way is that of the robot's middle."""
    move = frame(1.0) | {"type": "move", "left": 0, "right": 0, "linear": 0, "angular": 0}
    turning = {"left": 0, "right": 848, "back_left": 848, "back_right": 0}
    back = {"left": 0, "right": 0, "back_left": 0, "back_right": 9}
    seen = record(move | {"lateral": 600}, wheels(1.0, 0) | turning, move | {"lateral": 0})
    first, last = seen.frames
    assert (first.moves, first.speeds) == (True, (0, 0, 0, 600, 0))
    assert not last.moves
    seen.take([wheels(1.1, 0) | back])
    assert seen.stopping(1.0, 2.0).travelled_mm is None
    seen.take([wheels(1.2, 0) | dict.fromkeys(back, 0)])
    found = seen.stopping(1.05, 2.0).travelled_mm
    assert found == pytest.approx(math.hypot(424, 424) * 0.05 + 3.18 * 0.1, abs=0.1)
    omni = record(wheels(1.0, 0) | {"left": -250, "right": 250, "back": 500})
    assert omni.wheels[0].faster_mmps == pytest.approx(500)


def test_motion_after_a_stop_is_counted() -> None:
    """Each frame that moves the robot after it was stopped is wrong, and has its time."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), frame(1.2), frame(1.3))
    assert seen.stopping(1.05, 2.0).moved_again_ms == pytest.approx([150, 250])
    assert seen.stopping(1.05, 1.25).moved_again_ms == pytest.approx([150])


def test_a_stop_that_never_comes_has_no_time() -> None:
    """For a robot that keeps moving the time is None, which misses every goal (`tests.measure`)."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1), frame(1.2))
    stopping = seen.stopping(1.05, 2.0)
    assert stopping.told_ms is None


def test_a_robot_that_stood_before_was_not_moving() -> None:
    """A trial in which the robot had already stopped does not count."""
    seen = record(frame(1.0), wheels(1.0, 100), frame(1.1, "stop"), wheels(1.12, 0))
    assert seen.moved_at(1.05)
    assert not seen.moved_at(1.11)
    assert not seen.moved_at(1.5)
    assert not record(frame(1.0), wheels(1.0, 100)).moved_at(1.2)


DIRECTIONS = {1: 1, 2: -1}


def test_a_good_switch_is_a_stop_and_then_the_new_operator() -> None:
    """A stop between two operators' frames is no fault."""
    stop, back = frame(1.15, "stop", turn=2), frame(1.2, speed=-100, turn=2)
    good = record(frame(1.0), frame(1.1, "stop"), stop, back).frames
    found = switches(good, DIRECTIONS)
    assert (found.n, found.old, found.foreign, found.without_stop) == (1, 0, 0, 0)


def test_a_late_frame_is_found_though_the_board_refuses_it() -> None:
    """Motion for a turn that is over counts on the wire, and so does a switch without a stop."""
    refused = frame(1.3) | {"verdict": "old turn"}
    found = switches(record(frame(1.0), frame(1.2, speed=-100, turn=2), refused).frames, DIRECTIONS)
    assert (found.old, found.foreign, found.without_stop) == (1, 0, 1)


def test_the_previous_operators_motion_is_found_under_the_new_number() -> None:
    """Motion is foreign if the turn's operator drives the other way, or never had the turn."""
    frames = record(frame(1.0), frame(1.1, "stop"), frame(1.2, turn=2), frame(1.3, turn=3)).frames
    assert switches(frames, DIRECTIONS).foreign == 2


def test_halts_are_counted() -> None:
    """Each standstill after motion is one, however long it lasts."""
    frames = [frame(1.0), frame(1.1, "stop"), frame(1.2, "stop"), frame(1.3), frame(1.4, "stop")]
    assert halts(record(*frames).frames) == 2
