"""The picture that people drive by: whether it comes, and how well its age is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from wax.control.picture_clock import PictureClock
from wax.control.reasons import Refusal

if TYPE_CHECKING:
    from wax.sentence import Sentence


class DrivingCamera(Protocol):
    """What delivers the pictures."""

    @property
    def problem(self) -> Sentence | None: ...


class DrivingView:
    """`camera` is None for a robot without one."""

    def __init__(self) -> None:
        self.camera: DrivingCamera | None = None
        self.clock = PictureClock()

    def captured(self, captured_s: float, within_s: float | None) -> None:
        """Note the time of a picture, before anybody sees it; call it in the camera's thread."""
        self.clock = self.clock.after(captured_s, within_s)

    def problem(self, now_s: float) -> Sentence | None:
        """Return why nobody gets a picture to drive by; None without a camera."""
        problem = None if self.camera is None else self.camera.problem
        if problem is None and self.clock.is_doubted(now_s):
            return Refusal.UNDATED.value
        return problem
