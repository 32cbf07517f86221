"""Whether there is a picture to drive by."""

from __future__ import annotations

from types import SimpleNamespace

from wax.control.driving_view import DrivingView
from wax.control.reasons import Refusal
from wax.sentence import says


def test_a_view_has_the_problem_of_its_camera_before_that_of_its_clock() -> None:
    """Without a camera it has none; pictures of unknown age are one after three seconds."""
    view = DrivingView()
    assert view.problem(0.0) is None
    view.camera = camera = SimpleNamespace(problem=None)
    view.captured(1.0, None)
    assert view.problem(4.0) is None
    assert view.problem(4.1) == Refusal.UNDATED.value
    camera.problem = says("unplugged")
    assert view.problem(4.1) == says("unplugged")
    camera.problem = None
    view.captured(4.2, 0.01)
    assert view.problem(9.0) is None
