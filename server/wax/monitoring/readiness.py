"""Reports whether somebody could drive now: `/readyz`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.control.driving_view import DrivingView
    from wax.control.loop import ControlLoop

_BEAT_S: Final = 0.5
"""A control loop that has not run for this long, 25 ticks, is stuck."""
STOPPING: Final = "The server is stopping."
LATE: Final = "The control loop does not run."
DISCONNECTED: Final = "The robot is not connected."


class Readiness:
    """Call it for a sentence about each part that is not ready; empty if all are."""

    def __init__(
        self,
        *,
        clock: Clock,
        control: ControlLoop,
        view: DrivingView,
        is_stopping: Callable[[], bool],
    ) -> None:
        self._clock = clock
        self._control = control
        self._view = view
        self._is_stopping = is_stopping

    def __call__(self) -> dict[str, str]:
        missing = {}
        if self._is_stopping():
            missing["server"] = STOPPING
        now_s = self._clock.now_s()
        if now_s - self._control.stepped_s > _BEAT_S:
            missing["control"] = LATE
        state = self._control.robot_state
        if not state.connected or state.problem is not None:
            missing["robot"] = str(state.problem or DISCONNECTED)
        # The microphone is left out: the robot can be driven without sound.
        if (problem := self._view.problem(now_s)) is not None:
            missing["camera"] = str(problem)
        return missing
