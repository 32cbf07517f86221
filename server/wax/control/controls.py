"""What the robot has besides wheels: which of what people ask counts. Pure.

What is held - a button, and whatever moves - counts like a command: only from somebody who may use
it, for as long as a command would, and until the next of theirs that does not hold it. What moves
also needs everything that driving needs: its operator's turn, a fresh command of theirs with the
dead-man held, a fresh picture, no stop. Whatever ends that lets go of it, and then it must be
released and pressed again, as must what was held when a turn ended or somebody pressed Stop.

What is set - a toggle, a slider, a choice - stays as it is until somebody sets it otherwise, also
while the robot is stopped: nobody is helped by lights that go out. It is told as the state that it
shall have, never as a change, so that a page may repeat it until it hears that it has arrived.

Letting go is never refused for its age.
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
"""What is only set may be this old: an older wish may no longer be one."""


@dataclass(frozen=True, slots=True)
class Operation:
    """All that a page holds now, and what it sets, by the controls' names.

    Values are numbers: 1 for a button that is held or a toggle that is on, 0 for one that is off, a
    slider's own value, and the place of a choice in its list. `sent_s` is what the page claims,
    `heard_s` when the newest beat was sent that it had heard, as in `Command`.
    """

    seq: int
    turn: int
    sent_s: float
    held: Mapping[str, float] = field(default_factory=dict)
    wanted: Mapping[str, float] = field(default_factory=dict)
    heard_s: float = -math.inf


@dataclass(frozen=True, slots=True)
class ControlsOperator:
    """Somebody who operates controls: which roles they have, and the delay of their link."""

    viewer: int
    roles: frozenset[ControlRole]
    one_way_s: float | None


@dataclass(frozen=True, slots=True)
class Hand:
    """The newest operation of a viewer that counted; `held` counts until `until_s`.

    `spent` is what they still hold since before something let go of it.
    """

    seq: int
    turn: int
    until_s: float
    held: Mapping[str, float]
    spent: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class OperationState:
    """What is held by each viewer, and what was set."""

    hands: Mapping[int, Hand] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Working:
    """A control that is held or was set, and the value for the driver."""

    value: ControlValue
    moves: bool
    is_held: bool

    @property
    def released(self) -> ControlValue:
        """The value with which the driver learns that nobody holds it any more."""
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
        """Take what has just arrived, or return why not: all of it, or none."""
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

    def working(
        self, state: OperationState, turn: TurnView, *, may_move: bool, now_s: float
    ) -> dict[str, Working]:
        """Return every control that is held now, or was set; what is not in it is released."""
        found = {name: self._worked(name, value) for name, value in state.values.items()}
        for viewer, hand in state.hands.items():
            if now_s > hand.until_s:
                continue
            drives = viewer == turn.operator and hand.turn == turn.number
            for name, value in hand.held.items():
                counts = (may_move and drives) if self._moves(name) else True
                if counts and name not in hand.spent:
                    found[name] = self._worked(name, value)
        return found

    def stopped(self, state: OperationState) -> OperationState:
        """Let go of what moves, until it is pressed again."""
        return _spent(state, self._moves)

    def _moves(self, name: str) -> bool:
        return self._settings[name].moves

    def _worked(self, name: str, value: float) -> Working:
        control = self._settings[name]
        return Working(driver_value(control, value), control.moves, control.is_held)

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
        """Refuse what is for others, or for whoever drives in another turn."""
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
        """Refuse what is too old; else return until when what is held counts."""
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


def let_go(state: OperationState, viewer: int | None = None) -> OperationState:
    """Let go of all that is held, or all that this viewer holds, until it is pressed again."""
    return _spent(state, lambda _: True, viewer)


def begin_anew(state: OperationState, viewer: int) -> OperationState:
    """Let a new page of a viewer number its operations from the start; it holds nothing yet."""
    return replace(state, hands={one: hand for one, hand in state.hands.items() if one != viewer})


def driver_value(control: ControlSettings, value: float) -> ControlValue:
    """Return a value as the driver gets it."""
    match control.kind:
        case "slider":
            return float(value)
        case "choice":
            return control.choices[int(value)]
        case _:
            return value != 0


def _is_possible(control: ControlSettings, value: float) -> bool:
    """Whether a control can have this value; what is not a number never is."""
    match control.kind:
        case "button":
            return value == 1
        case "toggle":
            return value in (0, 1)
        case "slider":
            return control.min <= value <= control.max
        case _:
            return value in range(len(control.choices))


def _spent(
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
