"""Which requests for the robot's controls count."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rules import RULES, VOUCHED
from tests.examples import examples

from wax.config.controls import ControlSettings
from wax.control import controls
from wax.control.controls import Controls, ControlsOperator, Operation, OperationState
from wax.control.reasons import Refusal
from wax.control.turn_view import TurnView

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.config.controls import ControlRole
    from wax.driver.interface import ControlValue

A, B = 1, 2
TURN = TurnView(number=7, operator=A, present=True, one_way_s=0.1, sees=True, picture=VOUCHED)
TTL_S = RULES.max_age_s + 0.1
CONTROLS = Controls(
    [
        ControlSettings(name="lamp", kind="toggle", roles=["operator", "observer"]),
        ControlSettings(name="horn", kind="button", roles=["operator", "observer"]),
        ControlSettings(name="siren", kind="button", roles=["host"]),
        ControlSettings(name="dim", kind="slider", min=-5.0, max=5.0, step=0.5),
        ControlSettings(name="light", kind="choice", choices=["white", "red"]),
        ControlSettings(name="spin", kind="button", moves=True),
        ControlSettings(name="lift", kind="slider", min=-1.0, max=1.0, moves=True),
    ],
    RULES,
)
DRIVES: frozenset[ControlRole] = frozenset({"operator", "observer"})
WATCHES: frozenset[ControlRole] = frozenset({"observer"})


def asked(
    seq: int,
    *,
    sent_s: float = 10.0,
    turn: int = 7,
    held: Mapping[str, float] | None = None,
    wanted: Mapping[str, float] | None = None,
) -> Operation:
    return Operation(seq, turn, sent_s, held or {}, wanted or {}, heard_s=min(sent_s, 10.0))


def accept(
    state: OperationState,
    what: Operation,
    *,
    viewer: int = A,
    roles: frozenset[ControlRole] = DRIVES,
    now_s: float = 10.0,
    is_stopped: bool = False,
    one_way_s: float | None = 0.1,
) -> tuple[OperationState, Refusal | None]:
    by = ControlsOperator(viewer, roles, one_way_s)
    return CONTROLS.accept(state, by, what, turn=TURN, is_stopped=is_stopped, now_s=now_s)


def taken(state: OperationState, what: Operation, *, now_s: float = 10.0) -> OperationState:
    state, refusal = accept(state, what, now_s=now_s)
    assert refusal is None
    return state


def works(
    state: OperationState, *, now_s: float = 10.0, may_move: bool = True, turn: TurnView = TURN
) -> dict[str, ControlValue]:
    active = CONTROLS.active(state, turn, may_move=may_move, now_s=now_s)
    return {name: one.value for name, one in active.items()}


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("lamp", 1, True),
        ("lamp", 0, False),
        ("dim", 2.5, 2.5),
        ("dim", -5, -5.0),
        ("light", 0, "white"),
        ("light", 1, "red"),
    ],
)
def test_what_is_set_stays(name: str, value: float, told: ControlValue) -> None:
    """A toggle, a slider and a choice keep their value until somebody changes it."""
    state = taken(OperationState(), asked(1, wanted={name: value}))
    assert works(state, now_s=1e6, may_move=False) == {name: told}
    state = taken(state, asked(2))
    assert works(state) == {name: told}


def test_what_is_held_ends_with_its_command() -> None:
    """A horn sounds for a command's time-to-live, even while the robot is held."""
    state = taken(OperationState(), asked(1, held={"horn": 1}))
    assert works(state, may_move=False) == {"horn": True}
    assert works(state, now_s=10.0 + TTL_S) == {"horn": True}
    assert works(state, now_s=10.001 + TTL_S) == {}


def test_a_time_in_the_future_makes_nothing_last_longer() -> None:
    """A timestamp slightly ahead does not hold a horn for longer."""
    state = taken(OperationState(), asked(1, sent_s=10.1, held={"horn": 1}))
    assert works(state, now_s=10.001 + TTL_S) == {}


@pytest.mark.parametrize(
    ("viewer", "heard_s", "expected"),
    [
        (A, 9.31, None),
        (A, 9.29, Refusal.TOO_OLD),
        (B, 8.31, None),
        (B, 8.29, Refusal.TOO_OLD),
        (B, -math.inf, Refusal.TOO_OLD),
    ],
)
def test_what_is_held_is_as_old_as_its_beat(
    viewer: int, heard_s: float, expected: Refusal | None
) -> None:
    """A held control expires by its beat, which is older for viewers who do not drive."""
    held = replace(asked(1, held={"horn": 1}), heard_s=heard_s)
    roles = DRIVES if viewer == A else WATCHES
    state, refusal = accept(OperationState(), held, viewer=viewer, roles=roles)
    assert refusal is expected
    until_s = heard_s + (0.35 if viewer == A else 1.35) + 0.1 + TTL_S
    if expected is None:
        assert works(state, now_s=min(until_s, 10.0 + TTL_S) - 0.001) == {"horn": True}
        assert works(state, now_s=min(until_s, 10.0 + TTL_S) + 0.001) == {}


def test_letting_go_is_never_too_late() -> None:
    """A release counts however old it is, if nothing newer has arrived."""
    state = taken(OperationState(), asked(1, held={"horn": 1}))
    assert works(taken(state, asked(2, sent_s=1.0))) == {}
    assert accept(taken(state, asked(5, held={"horn": 1})), asked(2))[1] is Refusal.OUT_OF_ORDER


@pytest.mark.parametrize("name", ["spin", "lift"])
def test_what_moves_needs_all_that_driving_needs(name: str) -> None:
    """A moving control works only in its operator's turn, while driving is possible and held."""
    state = taken(OperationState(), asked(1, held={name: 1}))
    assert works(state) == {name: True if name == "spin" else 1.0}
    assert works(state, may_move=False) == {}
    assert works(state, turn=replace(TURN, number=8)) == {}
    assert works(state, turn=replace(TURN, operator=B)) == {}


@pytest.mark.parametrize(
    ("let_go", "left"),
    [
        (CONTROLS.release_moving, {"horn": True, "lamp": True}),
        (controls.release_held, {"lamp": True}),
        (lambda state: controls.release_held(state, A), {"lamp": True}),
        (lambda state: controls.release_held(state, B), {"horn": True, "lamp": True, "spin": True}),
    ],
)
def test_what_was_let_go_of_must_be_pressed_again(
    let_go: object, left: dict[str, ControlValue]
) -> None:
    """After a stop or a turn a held control must be released and pressed again."""
    assert callable(let_go)
    both = {"horn": 1.0, "spin": 1.0}
    state = taken(OperationState(), asked(1, held=both, wanted={"lamp": 1}))
    state = let_go(state)
    assert works(state) == left
    state = taken(state, asked(2, held=both))
    assert works(state) == left
    state = taken(state, asked(3, held={}))
    state = taken(state, asked(4, held=both))
    assert works(state) == {"horn": True, "lamp": True, "spin": True}


def test_one_is_released_while_another_is_held_on() -> None:
    """A control pressed again counts again, while one held throughout does not."""
    state = taken(OperationState(), asked(1, held={"horn": 1, "spin": 1}))
    state = controls.release_held(state)
    state = taken(state, asked(2, held={"horn": 1}))
    state = taken(state, asked(3, held={"horn": 1, "spin": 1}))
    assert works(state) == {"spin": True}


def test_a_stop_refuses_what_moves_alone() -> None:
    """While a Stop is in force lights and horn work, but nothing moves."""
    state, refusal = accept(OperationState(), asked(1, held={"spin": 1}), is_stopped=True)
    assert refusal is Refusal.STOPPED
    assert works(state) == {}
    state, refusal = accept(state, asked(2, held={"horn": 1}, wanted={"lamp": 1}), is_stopped=True)
    assert refusal is None
    assert works(state) == {"horn": True, "lamp": True}


@pytest.mark.parametrize(
    ("what", "changed", "refusal"),
    [
        (asked(1, wanted={"lmap": 1}), {}, Refusal.NO_SUCH_CONTROL),
        (asked(1, wanted={"horn": 1}), {}, Refusal.NO_SUCH_CONTROL),
        (asked(1, held={"lamp": 1}), {}, Refusal.NO_SUCH_CONTROL),
        (asked(1, held={"horn": 0}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, held={"lift": math.nan}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"lamp": 0.5}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"dim": 5.1}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"light": 2}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"light": 0.5}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"light": -1}), {}, Refusal.OUT_OF_RANGE),
        (asked(1, sent_s=math.nan), {}, Refusal.OUT_OF_RANGE),
        (asked(1, wanted={"lamp": 1}, sent_s=7.9), {}, Refusal.TOO_OLD),
        (asked(1, wanted={"lamp": 1}, sent_s=8.1), {}, None),
        (asked(1, held={"horn": 1}, sent_s=9.7), {}, Refusal.TOO_OLD),
        (asked(1, held={"horn": 1}, sent_s=10.2), {}, Refusal.FROM_FUTURE),
        (asked(1, held={"horn": 1}), {"one_way_s": 0.4}, Refusal.TOO_SLOW),
        (asked(1, wanted={"lamp": 1}), {"one_way_s": 0.4}, None),
        (asked(1, wanted={"dim": 1}, turn=6), {}, Refusal.OTHER_TURN),
        (asked(1, wanted={"lamp": 1}, turn=6), {}, None),
        (asked(1, wanted={"dim": 1}), {"viewer": B, "roles": WATCHES}, Refusal.NOT_YOUR_TURN),
        (asked(1, held={"siren": 1}), {}, Refusal.NOT_YOUR_CONTROL),
        (asked(1, held={"siren": 1}), {"viewer": B, "roles": frozenset({"host"})}, None),
        (asked(1, wanted={"lamp": 1}, turn=0), {"viewer": B, "roles": WATCHES}, None),
    ],
)
def test_what_is_refused(
    what: Operation, changed: dict[str, object], refusal: Refusal | None
) -> None:
    """Each reason to refuse an operation, and similar operations that are accepted."""
    state, why = accept(OperationState(), what, **changed)  # type: ignore[arg-type]  # a table
    assert why is refusal
    assert (state == OperationState()) is (refusal is not None)


def test_all_of_it_or_nothing() -> None:
    """One refused part refuses the whole operation, so that the page knows the outcome."""
    state, refusal = accept(OperationState(), asked(1, wanted={"lamp": 1, "dim": 9}))
    assert refusal is Refusal.OUT_OF_RANGE
    assert works(state) == {}


def test_a_new_page_counts_from_the_start() -> None:
    """A new page has its own numbers, and what the old page held is released."""
    state = taken(OperationState(), asked(9, held={"horn": 1}, wanted={"lamp": 1}))
    state = controls.reset_viewer(state, A)
    assert works(state) == {"lamp": True}
    assert works(taken(state, asked(0, held={"horn": 1}))) == {"lamp": True, "horn": True}


@dataclass(frozen=True)
class Word:
    """One thing that happens: the gap before it, and what it is."""

    gap_s: float
    what: str
    viewer: int
    turn: int
    seq_back: int
    delay_s: float
    held: dict[str, float]
    wanted: dict[str, float]


any_value = st.one_of(st.sampled_from([0.0, 1.0, 1.0, 1.0, 2.0]), st.floats())
words = st.builds(
    Word,
    gap_s=st.sampled_from([0.0, 0.01, 0.05, 0.2, 0.3]),
    what=st.sampled_from(["ask"] * 12 + ["stop", "open", "begin", "anew"]),
    viewer=st.sampled_from([A, A, A, B]),
    turn=st.sampled_from([7, 7, 7, 6]),
    seq_back=st.sampled_from([0, 0, 0, 1, 3]),
    delay_s=st.sampled_from([0.0, 0.0, 0.1, 0.24, 0.26, 1.0, 3.0, -0.1, -1.0]),
    held=st.dictionaries(st.sampled_from(["horn", "spin", "lift", "siren"]), any_value, max_size=2),
    wanted=st.dictionaries(st.sampled_from(["lamp", "dim", "light"]), any_value, max_size=2),
)


HELD = ("horn", "spin", "lift", "siren")
MOVING = ("spin", "lift")


@dataclass
class Judge:
    """A naive second implementation of the rules, for each viewer and control."""

    pressed_s: dict[tuple[int, str], float] = field(default_factory=dict)
    """The time of the newest message that held it, since it was pressed again."""
    is_spent: set[tuple[int, str]] = field(default_factory=set)
    newest: dict[int, set[str]] = field(default_factory=dict)

    def hear(self, viewer: int, held: Mapping[str, float], sent_s: float) -> None:
        self.newest[viewer] = set(held)
        for name in HELD:
            if name not in held:
                self.is_spent.discard((viewer, name))
                self.pressed_s.pop((viewer, name), None)
            elif (viewer, name) not in self.is_spent:
                self.pressed_s[viewer, name] = sent_s

    def let_go(self, names: tuple[str, ...]) -> None:
        for viewer, held in self.newest.items():
            for name in held & set(names):
                self.is_spent.add((viewer, name))
                self.pressed_s.pop((viewer, name), None)

    def anew(self, viewer: int) -> None:
        self.newest.pop(viewer, None)
        self.is_spent = {one for one in self.is_spent if one[0] != viewer}
        self.pressed_s = {one: at for one, at in self.pressed_s.items() if one[0] != viewer}

    def allows(self, name: str, now_s: float) -> bool:
        viewers = (A,) if name in MOVING else (A, B)
        return any(now_s - self.pressed_s.get((v, name), -math.inf) <= TTL_S for v in viewers)


@examples(300)
@given(st.lists(words, min_size=5, max_size=60))
def test_held_only_by_the_rules(trace: list[Word]) -> None:
    """Whatever is late, repeated or forged, only what was pressed again recently is held."""
    now_s, seq, is_stopped = 100.0, 0, False
    state, judge = OperationState(), Judge()
    for word in trace:
        now_s += word.gap_s
        match word.what:
            case "ask":
                seq += 1
                sent_s = now_s - word.delay_s
                what = Operation(
                    seq - word.seq_back, word.turn, sent_s, word.held, word.wanted, heard_s=now_s
                )
                before = state
                state, refusal = accept(
                    state,
                    what,
                    viewer=word.viewer,
                    roles=DRIVES if word.viewer == A else WATCHES,
                    now_s=now_s,
                    is_stopped=is_stopped,
                )
                assert refusal is None or state == before
                if refusal is None:
                    judge.hear(word.viewer, word.held, min(now_s, sent_s))
            case "stop":
                is_stopped, state = True, controls.release_held(state)
                judge.let_go(HELD)
            case "open":
                is_stopped = False
            case "begin":
                state = CONTROLS.release_moving(state)
                judge.let_go(MOVING)
            case _:
                seq += 5
                state = controls.reset_viewer(state, word.viewer)
                judge.anew(word.viewer)
        active = works(state, now_s=now_s)
        assert {one for one in HELD if one in active} == {
            one for one in HELD if judge.allows(one, now_s)
        }
        assert "siren" not in active  # nobody here is the host
        assert abs(float(active.get("lift") or 0)) <= 1
