"""The part of the control loop that passes lamps, grippers and other controls to the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.control import controls
from wax.control.controls import Controls, ControlsOperator, OperationState

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from wax.config.controls import ControlRole, ControlSettings
    from wax.control.controls import ActiveControl, Operation
    from wax.control.reasons import Refusal
    from wax.control.rules import Rules
    from wax.control.safe_driver import SafeDriver
    from wax.control.turn_view import TurnView
    from wax.sentence import Sentence


class ControlsLoop:
    """Keeps what all viewers hold and set, and sends the robot each resulting change."""

    def __init__(
        self, settings: Iterable[ControlSettings], rules: Rules, safe_driver: SafeDriver
    ) -> None:
        self._controls = Controls(settings, rules)
        self._safe_driver = safe_driver
        self._state = OperationState()

    @property
    def values(self) -> Mapping[str, float]:
        """The values of the controls that were set, not held."""
        return self._state.values

    def accept(
        self,
        viewer: int,
        asked: Operation,
        *,
        turn: TurnView,
        is_host: bool,
        one_way_s: float | None,
        is_stopped: bool,
        now_s: float,
    ) -> Refusal | None:
        """Accept an operation that has just arrived, or return why not; see `Controls.accept`."""
        drives = is_driving(viewer, turn)
        by = ControlsOperator(
            viewer,
            _roles(drives=drives, is_host=is_host),
            turn.one_way_s if drives else one_way_s,
        )
        self._state, refusal = self._controls.accept(
            self._state, by, asked, turn=turn, is_stopped=is_stopped, now_s=now_s
        )
        return refusal

    def reset_viewer(self, viewer: int) -> None:
        """Start a viewer's new page with nothing held."""
        self._state = controls.reset_viewer(self._state, viewer)

    def release_held(self, viewer: int | None = None) -> None:
        """Release all held controls, or one viewer's, until they are pressed again."""
        self._state = controls.release_held(self._state, viewer)

    def release_moving(self) -> None:
        """Release the controls that move, until they are pressed again."""
        self._state = self._controls.release_moving(self._state)

    def has_changes(self, turn: TurnView, *, may_move: bool, now_s: float) -> bool:
        """Whether a control of the robot has a new value that must be sent."""
        return self._safe_driver.changes_controls(self._active(turn, may_move, now_s))

    def send_changes(self, turn: TurnView, *, may_move: bool, now_s: float) -> Sentence | None:
        """Send the robot what has changed; return a sentence if its driver raised."""
        return self._safe_driver.operate(self._active(turn, may_move, now_s), turn.number)

    def _active(self, turn: TurnView, may_move: bool, now_s: float) -> Mapping[str, ActiveControl]:
        return self._controls.active(self._state, turn, may_move=may_move, now_s=now_s)


def is_driving(viewer: int, turn: TurnView) -> bool:
    """Whether a viewer has the turn, is connected, and the person aboard lets them drive."""
    is_left = turn.aboard is None or turn.aboard.mode == "free"
    return viewer == turn.operator and turn.present and is_left


def _roles(*, drives: bool, is_host: bool) -> frozenset[ControlRole]:
    roles: set[ControlRole] = {"observer"}
    if drives:
        roles.add("operator")
    if is_host:
        roles.add("host")
    return frozenset(roles)
