"""The robot's controls besides its wheels: which requests for them count. Pure.

A *held* control, such as a button or anything that moves, works like a command: only for somebody
who may use it, for a command's time-to-live, and until their next message no longer holds it. One
that moves also needs everything that driving needs: the operator's turn, a fresh command with the
dead-man held, a fresh picture, no stop. When any of these ends, it must be released and pressed
again, as must every control held when a turn ended or somebody pressed Stop.

A *set* control (a toggle, a slider, a choice) keeps its value until somebody changes it, even while
the robot is stopped: lights that go out help nobody. The page sends the value, never a change, so
that it may repeat the message until it is acknowledged.

A release is never refused for its age.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from wax.control.command_freshness import (
    CALM_HELD_S,
    HELD_S,
    credible_sent_s,
    is_from_future,
    is_too_old,
    time_to_live_s,
)
from wax.control.reasons import Refusal

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from wax.config.controls import ControlRole, ControlSettings
    from wax.control.rules import Rules
    from wax.control.turn_view import TurnView
    from wax.driver.interface import ControlValue

SET_TTL_S: Final = 2.0
"""The maximum age of a request that only sets: an older one may no longer be wanted."""


@dataclass(frozen=True, slots=True)
class Operation:
    """Everything that a page holds now, and the controls that it sets, by name.

    Values are numbers: 1 for a button that is held or a toggle that is on, 0 for one that is off, a
    slider's own value, and a choice's index in its list. `sent_s` and `heard_s` are as in
    `Command`.
    """

    seq: int
    turn: int
    sent_s: float
    held: Mapping[str, float] = field(default_factory=dict)
    wanted: Mapping[str, float] = field(default_factory=dict)
    heard_s: float = -math.inf


@dataclass(frozen=True, slots=True)
class ControlsOperator:
    """A viewer who operates controls: their roles, and the delay of their link."""

    viewer: int
    roles: frozenset[ControlRole]
    one_way_s: float | None


@dataclass(frozen=True, slots=True)
class Hand:
    """The newest operation of a viewer that counted; `held` counts until `until_s`.

    `spent` are the held controls that have been released for them and must be pressed again.
    """

    seq: int
    turn: int
    until_s: float
    held: Mapping[str, float]
    spent: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class OperationState:
    """What each viewer holds, and the values that were set."""

    hands: Mapping[int, Hand] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ActiveControl:
    """A control that is held or was set: its number as in `Operation`, and the driver's value."""

    number: float
    value: ControlValue
    moves: bool
    is_held: bool

    @property
    def released(self) -> ControlValue:
        """The value that tells the driver that nobody holds the control any more."""
        return False if isinstance(self.value, bool) else None


class Controls:
    """The controls as configured, with the rules for them."""

    def __init__(self, settings: Iterable[ControlSettings], rules: Rules) -> None:
        self._settings = {one.name: one for one in settings}
        self._rules = rules

    def accept(
        self,
        state: OperationState,
        by: ControlsOperator,
        operation: Operation,
        *,
        turn: TurnView,
        is_stopped: bool,
        now_s: float,
    ) -> tuple[OperationState, Refusal | None]:
        """Accept an operation that has just arrived, or return why not: all of it or none."""
        hand = state.hands.get(by.viewer)
        if hand is not None and operation.seq <= hand.seq:
            return state, Refusal.OUT_OF_ORDER
        refusal = self._unknown(operation) or self._not_allowed(by, operation, turn)
        if refusal is None and is_stopped and any(self._moves(name) for name in operation.held):
            refusal = Refusal.STOPPED
        until_s = math.inf
        if refusal is None and (operation.held or operation.wanted):
            held_s = HELD_S if by.viewer == turn.operator else CALM_HELD_S
            refusal, until_s = self._untimely(by, operation, held_s, now_s)
        if refusal is not None:
            return state, refusal
        spent = frozenset() if hand is None else hand.spent & operation.held.keys()
        newest = Hand(operation.seq, operation.turn, until_s, operation.held, spent)
        return OperationState(
            {**state.hands, by.viewer: newest}, {**state.values, **operation.wanted}
        ), None

    def active(
        self, state: OperationState, turn: TurnView, *, may_move: bool, now_s: float
    ) -> dict[str, ActiveControl]:
        """Return every control that is held now or was set; all others are released."""
        found = {name: self._active_control(name, value) for name, value in state.values.items()}
        for viewer, hand in state.hands.items():
            if now_s > hand.until_s:
                continue
            drives = viewer == turn.operator and hand.turn == turn.number
            for name, value in hand.held.items():
                counts = (may_move and drives) if self._moves(name) else True
                if counts and name not in hand.spent:
                    found[name] = self._active_control(name, value)
        return found

    def release_moving(self, state: OperationState) -> OperationState:
        """Release the controls that move, until they are pressed again."""
        return _release(state, self._moves)

    def _moves(self, name: str) -> bool:
        return self._settings[name].moves

    def _active_control(self, name: str, value: float) -> ActiveControl:
        control = self._settings[name]
        return ActiveControl(value, driver_value(control, value), control.moves, control.is_held)

    def _unknown(self, operation: Operation) -> Refusal | None:
        if not math.isfinite(operation.sent_s):
            return Refusal.OUT_OF_RANGE
        for values, is_held in ((operation.held, True), (operation.wanted, False)):
            for name, value in values.items():
                control = self._settings.get(name)
                if control is None or control.is_held is not is_held:
                    return Refusal.NO_SUCH_CONTROL
                if not _is_possible(control, value):
                    return Refusal.OUT_OF_RANGE
        return None

    def _not_allowed(
        self, by: ControlsOperator, operation: Operation, turn: TurnView
    ) -> Refusal | None:
        """Refuse controls that are for other roles, or for the operator of another turn."""
        drives = by.viewer == turn.operator and "operator" in by.roles
        is_theirs = drives and operation.turn == turn.number
        roles = by.roles if is_theirs else by.roles - {"operator"}
        for name in (*operation.held, *operation.wanted):
            wanted = self._settings[name].roles
            if roles.isdisjoint(wanted):
                if "operator" not in wanted:
                    return Refusal.NOT_YOUR_CONTROL
                return Refusal.OTHER_TURN if drives else Refusal.NOT_YOUR_TURN
        return None

    def _untimely(
        self, by: ControlsOperator, operation: Operation, held_s: float, now_s: float
    ) -> tuple[Refusal | None, float]:
        """Refuse an operation that is too old; else return when what it holds expires."""
        ttl_s = time_to_live_s(by.one_way_s, self._rules) if operation.held else SET_TTL_S
        if ttl_s is None:
            return Refusal.TOO_SLOW, math.inf
        sent_s = credible_sent_s(
            operation.sent_s, operation.heard_s, now_s, one_way_s=by.one_way_s, held_s=held_s
        )
        if is_too_old(sent_s, now_s, ttl_s):
            return Refusal.TOO_OLD, math.inf
        if is_from_future(operation.sent_s, now_s, one_way_s=by.one_way_s):
            return Refusal.FROM_FUTURE, math.inf
        return None, sent_s + ttl_s


def release_held(state: OperationState, viewer: int | None = None) -> OperationState:
    """Release all held controls, or this viewer's, until they are pressed again."""
    return _release(state, lambda _: True, viewer)


def reset_viewer(state: OperationState, viewer: int) -> OperationState:
    """Start a viewer's new page: it numbers operations from the start and holds nothing."""
    return replace(state, hands={one: hand for one, hand in state.hands.items() if one != viewer})


def driver_value(control: ControlSettings, value: float) -> ControlValue:
    """Return a value in the form that the driver gets."""
    match control.kind:
        case "slider":
            return float(value)
        case "choice":
            return control.choices[int(value)]
        case _:
            return value != 0


def _is_possible(control: ControlSettings, value: float) -> bool:
    """Whether a control can have this value; NaN never is."""
    match control.kind:
        case "button":
            return value == 1
        case "toggle":
            return value in (0, 1)
        case "slider":
            return control.min <= value <= control.max
        case _:
            return value in range(len(control.choices))


def _release(
    state: OperationState, is_let_go: Callable[[str], bool], viewer: int | None = None
) -> OperationState:
    if not any(hand.held for hand in state.hands.values()):
        return state
    hands = {
        one: replace(hand, spent=hand.spent | {name for name in hand.held if is_let_go(name)})
        if viewer in (None, one)
        else hand
        for one, hand in state.hands.items()
    }
    return replace(state, hands=hands)
