"""What people hold and set of the robot's controls, and telling it: the loop's part for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.control import controls
from wax.control.controls import Controls, ControlsOperator, OperationState

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from wax.config.controls import ControlRole, ControlSettings
    from wax.control.controls import Operation, Working
    from wax.control.reasons import Refusal
    from wax.control.rules import Rules
    from wax.control.safe_driver import SafeDriver
    from wax.control.turn_view import TurnView
    from wax.sentence import Sentence


class ControlsLoop:
    """Remembers the operations of all viewers, and keeps the robot told of what they make."""

    def __init__(
        self, settings: Iterable[ControlSettings], rules: Rules, safe_driver: SafeDriver
    ) -> None:
        self._controls = Controls(settings, rules)
        self._safe_driver = safe_driver
        self._state = OperationState()

    @property
    def values(self) -> Mapping[str, float]:
        """How the controls were set that stay as they are set."""
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
        """Take what has just arrived, or return why not; see `Controls.accept`."""
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

    def begin_anew(self, viewer: int) -> None:
        """Let a new page of a viewer begin, with nothing held."""
        self._state = controls.begin_anew(self._state, viewer)

    def let_go(self, viewer: int | None = None) -> None:
        """Let go of all that is held, or all that a viewer holds, until it is pressed again."""
        self._state = controls.let_go(self._state, viewer)

    def stop_moving(self) -> None:
        """Let go of what moves, until it is pressed again."""
        self._state = self._controls.stopped(self._state)

    def is_news(self, turn: TurnView, *, may_move: bool, now_s: float) -> bool:
        """Whether the robot would have to be told something."""
        return self._safe_driver.changes_controls(self._working(turn, may_move, now_s))

    def tell(self, turn: TurnView, *, may_move: bool, now_s: float) -> Sentence | None:
        """Tell the robot what has changed; return a sentence if its driver raised."""
        return self._safe_driver.operate(self._working(turn, may_move, now_s), turn.number)

    def _working(self, turn: TurnView, may_move: bool, now_s: float) -> Mapping[str, Working]:
        return self._controls.working(self._state, turn, may_move=may_move, now_s=now_s)


def is_driving(viewer: int, turn: TurnView) -> bool:
    """Whether a viewer has the robot: their turn, connected, and left to them by who is aboard."""
    is_left = turn.aboard is None or turn.aboard.mode == "free"
    return viewer == turn.operator and turn.present and is_left


def _roles(*, drives: bool, is_host: bool) -> frozenset[ControlRole]:
    roles: set[ControlRole] = {"observer"}
    if drives:
        roles.add("operator")
    if is_host:
        roles.add("host")
    return frozenset(roles)
