"""What the driver process lets through."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.velocity import fraction

from wax.config.controls import ControlSettings
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import ControlValue, Limits, Twist
from wax.robot.process.driver_watchdog import (
    GARBLED,
    NEUTRAL_FIRST,
    SILENT,
    Apply,
    Call,
    DriverWatchdog,
    SetAxis,
    SetControl,
    StopDriver,
)
from wax.robot.process.pipe_messages import Axis, Control, Halt, Message, Move

LIMITS = Limits(linear_mps=0.6, angular_rps=1.5, axes=("pan",), lateral_mps=0.3)
CONTROLS = [
    ControlSettings(name="lamp", kind="toggle"),
    ControlSettings(name="horn", kind="button"),
    ControlSettings(name="spin", kind="button", moves=True),
    ControlSettings(name="lift", kind="slider", moves=True),
]
SILENCE_S = 0.125  # a power of two, so that the edge is exact


class Server:
    """Sends what a server would, with rising sequence numbers, and returns the resulting calls."""

    def __init__(self) -> None:
        self.warden = DriverWatchdog(LIMITS, SILENCE_S, CONTROLS)
        self.now_s = 100.0
        self.sequence = 0

    def drive(
        self,
        linear: float,
        angular: float = 0.0,
        lateral: float = 0.0,
        *,
        turn: int = 1,
        age_s: float = 0.0,
        sequence: int | None = None,
        ends_in_s: float | None = None,
    ) -> tuple[Call, ...]:
        return self.warden.handle(
            Move(
                sequence=self._next() if sequence is None else sequence,
                sent_s=self.now_s - age_s,
                turn=turn,
                linear_mps=linear,
                angular_rps=angular,
                lateral_mps=lateral,
                end_s=None if ends_in_s is None else self.now_s + ends_in_s,
            ),
            self.now_s,
        )

    def pan(self, position: float, *, turn: int = 1, name: str = "pan") -> tuple[Call, ...]:
        axis = Axis(
            sequence=self._next(), sent_s=self.now_s, turn=turn, name=name, position=position
        )
        return self.warden.handle(axis, self.now_s)

    def control(
        self, name: str, value: ControlValue, *, turn: int = 1, age_s: float = 0.0
    ) -> tuple[Call, ...]:
        sent_s = self.now_s - age_s
        control = Control(sequence=self._next(), sent_s=sent_s, turn=turn, name=name, value=value)
        return self.warden.handle(control, self.now_s)

    def halt(
        self, *, turn: int = 1, age_s: float = 0.0, sequence: int | None = None
    ) -> tuple[Call, ...]:
        number = self._next() if sequence is None else sequence
        halt = Halt(sequence=number, sent_s=self.now_s - age_s, turn=turn)
        return self.warden.handle(halt, self.now_s)

    def driving(self) -> Server:
        """Stand, then drive ahead in turn 1."""
        self.drive(0.0)
        assert self.drive(0.5) == (ahead(),)
        return self

    def wait(self, seconds: float) -> tuple[Call, ...]:
        self.now_s += seconds
        return self.warden.repeat(self.now_s)

    def _next(self) -> int:
        self.sequence += 1
        return self.sequence


def apply(linear: float, angular: float = 0.0, turn: int = 1) -> Apply:
    return Apply(Twist(linear, angular), turn)


def ahead(turn: int = 1) -> Apply:
    return apply(0.5, turn=turn)


@pytest.fixture
def server() -> Server:
    return Server()


def test_before_anything_was_said_it_is_told_to_stand(server: Server) -> None:
    """Before the first message the watchdog repeats standstill, and silence has no effect."""
    assert server.wait(0.02) == (apply(0.0, turn=0),)
    assert server.wait(1000.0) == (apply(0.0, turn=0),)
    assert server.warden.silent_at_s == math.inf
    assert (server.warden.problem, server.warden.holds) == (None, 0)


def test_a_turn_begins_with_a_stop_and_moves_after_standstill(server: Server) -> None:
    """A turn begins with a stop; motion passes only after a set-point of standstill."""
    assert server.drive(0.0) == (StopDriver(1), apply(0.0))
    assert server.drive(0.5, 0.25) == (apply(0.5, 0.25),)
    assert server.wait(0.02) == (apply(0.5, 0.25),)
    assert server.warden.problem is None


def test_a_part_of_motion_is_no_standstill(server: Server) -> None:
    """Only complete standstill allows motion: neither turning, going straight nor NaN does."""
    for twist in ((0.0, 0.1), (0.1, 0.0), (math.nan, 0.0), (0.0, math.nan)):
        assert server.drive(*twist)[-1] == apply(0.0)
    assert server.drive(0.5) == (apply(0.0),)


def test_motion_without_standstill_says_so(server: Server) -> None:
    """Motion before standstill is refused, counted and reported; standstill resolves it."""
    assert server.drive(0.5) == (StopDriver(1), apply(0.0))
    assert server.warden.problem == NEUTRAL_FIRST
    assert server.pan(0.5) == ()
    assert server.warden.counts["driver_unarmed"] == 2
    server.drive(0.0)
    assert server.warden.problem is None
    assert server.drive(0.5) == (ahead(),)
    assert server.warden.holds == 0


def test_silence_stops_at_its_moment(server: Server) -> None:
    """The set-point is repeated until silence; then come one stop and standstill."""
    server.driving()
    assert server.warden.silent_at_s == server.now_s + SILENCE_S
    assert server.wait(SILENCE_S - 0.001) == (ahead(),)
    assert server.wait(0.001) == (StopDriver(1), apply(0.0))
    assert server.wait(0.02) == (apply(0.0),)
    assert server.warden.silent_at_s == math.inf
    assert server.warden.problem == SILENT
    assert server.warden.counts["driver_silences"] == 1
    assert server.warden.holds == 1


def test_a_command_ends_although_the_server_repeats_it(server: Server) -> None:
    """A command's expiry stops the robot even if the server keeps repeating it."""
    server.driving()
    assert server.drive(0.5, ends_in_s=0.05) == (ahead(),)
    server.now_s += 0.03
    assert server.drive(0.5, ends_in_s=0.02) == (ahead(),)
    assert server.wait(0.015) == (ahead(),)
    assert server.wait(0.005) == (StopDriver(1), apply(0.0))
    assert server.drive(0.5, ends_in_s=0.0) == ()
    assert server.warden.counts["driver_stale"] == 1


def test_standstill_has_no_end(server: Server) -> None:
    """Standstill does not expire, nor does a set-point whose command was superseded."""
    server.driving().drive(0.5, ends_in_s=0.05)
    assert server.drive(0.25) == (apply(0.25),)
    assert server.warden.silent_at_s == server.now_s + SILENCE_S


def test_silence_is_reckoned_from_the_stamp(server: Server) -> None:
    """Silence counts from the timestamp, so a delayed message prolongs nothing."""
    server.driving()
    server.now_s += 0.1
    assert server.drive(0.5, age_s=0.05) == (ahead(),)
    assert server.warden.silent_at_s == server.now_s - 0.05 + SILENCE_S
    server.drive(0.5, age_s=0.06)  # written later, but stamped before
    assert server.warden.silent_at_s == server.now_s - 0.05 + SILENCE_S


def test_silence_comes_before_what_waited(server: Server) -> None:
    """After a sleep the process stops the robot first, and queued set-points do not move it."""
    server.driving()
    server.now_s += 0.2
    assert server.drive(0.5, age_s=0.15) == (StopDriver(1),)
    assert server.warden.counts["driver_stale"] == 1
    assert server.drive(0.5, age_s=0.01) == (apply(0.0),)
    assert server.drive(0.0, age_s=0.005) == (apply(0.0),)  # from before the stop
    assert server.drive(0.5) == (apply(0.0),)
    assert server.warden.problem == SILENT
    server.now_s += 0.01
    assert server.drive(0.0) == (apply(0.0),)
    assert server.warden.problem is None
    assert server.drive(0.5) == (ahead(),)


def test_standstill_of_the_very_moment_of_the_stop_does_not_arm(server: Server) -> None:
    """Standstill counts only with a timestamp later than the stop."""
    server.driving().warden.handle_invalid(server.now_s)
    server.drive(0.0)
    assert server.drive(0.5) == (apply(0.0),)


@pytest.mark.parametrize(("age_s", "passes"), [(0.124, True), (0.125, False), (-0.001, False)])
def test_age_is_judged_by_the_stamp(server: Server, age_s: float, passes: bool) -> None:
    """Neither a set-point as old as the silence limit nor one from the future moves the robot."""
    server.driving()
    server.now_s += 0.02
    assert server.drive(0.25, age_s=age_s) == ((apply(0.25),) if passes else ())
    assert server.warden.counts["driver_stale"] == (not passes)


def test_what_is_refused_does_not_end_the_silence(server: Server) -> None:
    """Refused set-points and axes do not end the silence."""
    server.driving()
    end_s = server.warden.silent_at_s
    server.now_s += 0.05
    assert server.drive(0.25, sequence=2) == ()
    assert server.drive(0.25, sequence=1) == ()
    assert server.drive(0.25, turn=0) == ()
    assert server.pan(0.5) == (SetAxis("pan", 0.5, 1),)
    assert server.warden.silent_at_s == end_s
    assert server.warden.counts["driver_repeated"] == 2
    assert server.warden.counts["driver_old_turn"] == 1


def test_the_first_number_may_be_zero(server: Server) -> None:
    """Sequence numbers start at zero."""
    assert server.drive(0.0, sequence=0) == (StopDriver(1), apply(0.0))


def test_an_axis_counts_in_the_sequence(server: Server) -> None:
    """Axes count in the sequence: a set-point overtaken by one is refused."""
    server.driving().pan(0.5)
    assert server.drive(0.25, sequence=server.sequence) == ()


def test_an_axis_that_is_not_there_is_not_moved(server: Server) -> None:
    """Only the robot's own axes are."""
    assert server.driving().pan(0.5, name="tilt") == ()


def test_a_new_turn_needs_its_own_standstill(server: Server) -> None:
    """Between two turns comes a stop, and the old turn's standstill does not count in the new."""
    server.driving()
    assert server.drive(0.5, turn=2) == (StopDriver(2), apply(0.0, turn=2))
    assert server.drive(0.5, turn=1) == ()
    assert server.pan(0.5, turn=1) == ()
    assert server.warden.counts["driver_old_turn"] == 2
    server.drive(0.0, turn=2)
    assert server.drive(0.5, turn=2) == (ahead(turn=2),)
    assert server.pan(0.5, turn=3) == (StopDriver(3),)


def test_a_stop_is_never_refused(server: Server) -> None:
    """A stop always works, even if old, repeated, of a past turn or from the future."""
    for halt in (
        {"age_s": 10.0},
        {"sequence": 1},
        {"turn": 0},
        {"age_s": -10.0},
        {"turn": 0, "age_s": 10.0, "sequence": 0},
    ):
        server = Server().driving()
        assert server.halt(**halt) == (StopDriver(1),)
        assert server.wait(0.02) == (apply(0.0),)
        assert server.warden.silent_at_s <= server.now_s + SILENCE_S


def test_after_a_stop_it_goes_on(server: Server) -> None:
    """A stop is not a fault: motion may follow without standstill, which the server decides."""
    server.driving().halt()
    assert server.drive(0.5, sequence=server.sequence) == ()
    assert server.drive(0.5) == (ahead(),)


def test_a_past_stop_does_not_turn_the_numbers_back(server: Server) -> None:
    """A repeated old stop does not lower the sequence number."""
    server.driving().halt(sequence=1)
    assert server.drive(0.25, sequence=2) == ()


def test_a_stop_ends_the_silence(server: Server) -> None:
    """A fresh stop ends the silence, a queued one does not."""
    server.driving()
    server.now_s += 0.05
    server.halt()
    assert server.warden.silent_at_s == server.now_s + SILENCE_S
    server.now_s += 0.2
    assert server.halt(age_s=0.15) == (StopDriver(1), StopDriver(1))
    assert server.warden.silent_at_s == math.inf


def test_the_stop_of_a_new_turn_needs_standstill_after_it(server: Server) -> None:
    """The stop of a new turn ends the old turn, and standstill must follow."""
    assert server.driving().halt(turn=2) == (StopDriver(2),)
    assert server.drive(0.5, turn=1) == ()
    assert server.drive(0.5, turn=2) == (apply(0.0, turn=2),)


def test_garbage_holds_the_robot(server: Server) -> None:
    """An invalid message stops the robot."""
    assert server.driving().warden.handle_invalid(server.now_s) == (StopDriver(1),)
    assert server.warden.problem == GARBLED
    assert server.warden.counts["driver_garbage"] == 1
    assert server.warden.silent_at_s == math.inf  # it is stopped already
    assert server.wait(0.02) == (apply(0.0),)
    assert server.drive(0.5) == (apply(0.0),)
    assert server.warden.problem == GARBLED  # the first reason stays


def test_standstill_from_before_the_hold_is_no_offence(server: Server) -> None:
    """Standstill from before a hold does not end the hold, but is not counted as refused motion."""
    server.driving().warden.handle_invalid(server.now_s)
    assert server.drive(0.0, age_s=0.02) == (apply(0.0),)
    assert server.warden.counts["driver_unarmed"] == 0
    assert server.drive(0.5) == (apply(0.0),)
    assert server.warden.counts["driver_unarmed"] == 1


def test_a_driver_that_raises_holds_the_robot(server: Server) -> None:
    """A driver that raises is stopped, with `NO_ANSWER` as the problem."""
    assert server.driving().warden.failed(server.now_s) == (StopDriver(1),)
    assert server.warden.problem == NO_ANSWER
    assert server.warden.counts["driver_failures"] == 1
    assert server.warden.holds == 1


@pytest.mark.parametrize(
    ("asked", "given"),
    [
        ((6.0, 1.5, 0.0), (0.6, 0.15, 0.0)),
        ((-6.0, 0.0, 0.0), (-0.6, 0.0, 0.0)),
        ((4.8, 0.0, -1.8), (0.48, 0.0, -0.18)),
        ((math.inf, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, math.nan, 0.0), (0.0, 0.0, 0.0)),
        ((0.5, 0.0, math.nan), (0.0, 0.0, 0.0)),
    ],
)
def test_limits_hold_once_more(
    server: Server, asked: tuple[float, ...], given: tuple[float, ...]
) -> None:
    """Set-points beyond the limits are scaled down along their curve, and NaN is standstill."""
    (call,) = server.driving().drive(*asked)
    assert isinstance(call, Apply)
    assert astuple(call.twist) == pytest.approx(given)


# --- whatever is said, in whatever order ---------------------------------------------------


@dataclass(frozen=True)
class Word:
    """One event: the message, its delay, its age by timestamp, and how its numbers differ."""

    what: str
    after_s: float
    age_s: float
    turn: int
    back: int
    linear: float
    angular: float
    lateral: float
    ends_s: float | None


WORDS = st.lists(
    st.builds(
        Word,
        what=st.sampled_from(
            ["move", "move", "move", "stand", "axis", "spin", "let go", "halt", "garbage", "beat"]
        ),
        after_s=st.sampled_from([0.0, 0.01, 0.02, 0.05, 0.2]),
        age_s=st.sampled_from([0.0, 0.0, 0.0, 0.05, 0.2, -0.5]),
        turn=st.integers(0, 3),
        back=st.sampled_from([0, 0, 0, 1, 2]),
        linear=st.one_of(st.sampled_from([0.5, -0.5, 0.0]), st.floats()),
        angular=st.one_of(st.just(0.0), st.floats()),
        lateral=st.one_of(st.just(0.0), st.floats()),
        ends_s=st.sampled_from([None, None, 0.03, 0.06, -0.01]),
    ),
    max_size=40,
)


class Model:
    """A second implementation of the rules, with which the watchdog is compared."""

    def __init__(self) -> None:
        self.warden = DriverWatchdog(LIMITS, SILENCE_S)
        self.now_s = 100.0
        self.sequence = -1
        self.turn = 0
        self.spins = False
        self.stopped_s = -math.inf  # of the newest fault
        self.neutral_s = -math.inf  # when standstill was heard in this turn
        self.word_s = -math.inf  # stamp of the newest set-point or stop
        self.end_s = math.inf  # of the command behind it
        self.heard = False  # whether there was one since the newest fault
        self.halted = True

    def meet(self, word: Word) -> None:
        self.now_s += word.after_s
        if self.heard and self._is_silent():
            self._fault()
        calls = self._say(word)
        for number, call in enumerate(calls):
            if isinstance(call, StopDriver):
                assert call.turn <= self.turn
                self.spins = False
                continue
            if isinstance(call, SetControl) and call.is_release:
                self.spins = False
                continue
            assert call.turn == self.turn
            assert number == len(calls) - 1, "nothing moves before a stop of the same moment"
            self._judge(call)
        if self.spins:
            assert not self._is_silent(), "nothing is held on in silence"
            assert self.neutral_s > self.stopped_s, "nor through a fault"

    def _is_silent(self) -> bool:
        return self.now_s - self.word_s >= SILENCE_S or self.now_s >= self.end_s

    def _fault(self) -> None:
        self.stopped_s, self.heard = self.now_s, False

    def _say(self, word: Word) -> tuple[Call, ...]:
        if word.what == "beat":
            return self.warden.repeat(self.now_s)
        if word.what == "garbage":
            self._fault()
            return self.warden.handle_invalid(self.now_s)
        message = self._message(word)
        self._note(message)
        return self.warden.handle(message, self.now_s)

    def _message(self, word: Word) -> Message:
        number = max(0, self.sequence + 1 - word.back)
        sent_s, turn = self.now_s - word.age_s, word.turn
        if word.what == "halt":
            return Halt(sequence=number, sent_s=sent_s, turn=turn)
        if word.what == "axis":
            return Axis(sequence=number, sent_s=sent_s, turn=turn, name="pan", position=0.5)
        if word.what in ("spin", "let go"):
            value = word.what == "spin"
            return Control(sequence=number, sent_s=sent_s, turn=turn, name="spin", value=value)
        still = word.what == "stand"
        return Move(
            sequence=number,
            sent_s=sent_s,
            turn=turn,
            linear_mps=0.0 if still else word.linear,
            angular_rps=0.0 if still else word.angular,
            lateral_mps=0.0 if still else word.lateral,
            end_s=None if word.ends_s is None else self.now_s + word.ends_s,
        )

    def _note(self, message: Message) -> None:
        fresh = 0.0 <= self.now_s - message.sent_s < SILENCE_S
        end_s = math.inf
        if isinstance(message, Move) and message.end_s is not None:
            end_s = message.end_s
        taken = fresh and message.sequence > self.sequence and message.turn >= self.turn
        taken = taken and self.now_s < end_s
        if isinstance(message, Halt) or taken:
            self.sequence = max(self.sequence, message.sequence)
            if message.turn > self.turn:
                self.turn, self.neutral_s, self.halted = message.turn, -math.inf, True
        if isinstance(message, Halt):
            self.halted = True
        if isinstance(message, Halt) and fresh:
            self.word_s, self.heard = max(self.word_s, message.sent_s), True
            self.end_s = math.inf
        if isinstance(message, Move) and taken:
            self.word_s, self.heard = max(self.word_s, message.sent_s), True
            self.end_s = end_s
            self.halted = False
            if not any((message.linear_mps, message.angular_rps, message.lateral_mps)):
                self.neutral_s = max(self.neutral_s, message.sent_s)

    def _judge(self, call: Apply | SetAxis | SetControl) -> None:
        if isinstance(call, Apply):
            assert fraction(call.twist, LIMITS) <= 1.0 + 1e-9
            assert abs(call.twist.angular_rps) <= LIMITS.angular_rps
            if call.twist.is_zero:
                return
            assert not self.halted
        assert self.neutral_s > self.stopped_s, "neutral first, stamped after the newest fault"
        if isinstance(call, Apply):
            assert not self._is_silent(), "nothing moves in silence"
        elif isinstance(call, SetControl):
            self.spins = True


@given(WORDS)
def test_nothing_moves_that_must_not(words: list[Word]) -> None:
    """In any order of messages nothing moves in silence, of an old turn, or before standstill."""
    model = Model()
    for word in words:
        model.meet(word)


@given(WORDS)
def test_who_begins_anew_drives(words: list[Word]) -> None:
    """Whatever came before, standstill and then motion of the newest turn moves the robot."""
    model = Model()
    for word in words:
        model.meet(word)
    warden, now_s = model.warden, model.now_s
    for number, linear in enumerate((0.0, 0.0, 0.5)):
        now_s += 0.02
        calls = warden.handle(
            Move(
                sequence=model.sequence + 1 + number,
                sent_s=now_s,
                turn=model.turn,
                linear_mps=linear,
                angular_rps=0.0,
            ),
            now_s,
        )
    assert calls == (ahead(model.turn),)
    assert warden.problem is None


def light(value: ControlValue, name: str = "lamp", turn: int = 1) -> SetControl:
    return SetControl(name, value, turn, moves=False)


def motion(name: str, value: ControlValue, turn: int = 1) -> SetControl:
    return SetControl(name, value, turn, moves=True)


def test_a_lamp_needs_no_standstill(server: Server) -> None:
    """A control that only lights or sounds works at once, whatever holds the robot."""
    assert server.control("lamp", True) == (StopDriver(1), light(True))
    assert server.control("horn", True) == (light(True, "horn"),)
    assert server.control("lmap", True) == ()
    assert server.warden.problem is None


def test_a_control_is_refused_as_an_axis_is(server: Server) -> None:
    """Old controls, and those of old turns, are refused; moving ones must wait for standstill."""
    server.driving()
    assert server.control("lamp", True, age_s=SILENCE_S) == ()
    assert server.control("lamp", True, turn=0) == ()
    assert server.warden.counts["driver_stale"] == server.warden.counts["driver_old_turn"] == 1
    assert server.control("lift", 0.5) == (motion("lift", 0.5),)
    server.warden.hold(None, server.now_s)
    assert server.control("lift", 0.5) == ()
    assert server.warden.problem == NEUTRAL_FIRST
    assert server.warden.counts["driver_unarmed"] == 1


def test_silence_lets_go_of_what_is_held(server: Server) -> None:
    """Silence releases the horn and moving controls, while the lamp stays on."""
    server.driving()
    server.control("lamp", True)
    server.control("horn", True)
    server.control("spin", True)
    server.control("lift", -1.0)
    assert server.wait(SILENCE_S)[:-1] == (
        StopDriver(1),
        light(False, "horn"),
        motion("spin", False),
        motion("lift", None),
    )
    assert server.wait(SILENCE_S) == (apply(0.0),)


def test_a_stop_lets_go_of_what_moves(server: Server) -> None:
    """A stop releases only moving controls, so that the horn may still warn people."""
    server.driving()
    server.control("horn", True)
    server.control("spin", True)
    assert server.halt() == (StopDriver(1), motion("spin", False))
    assert server.halt() == (StopDriver(1),)
    assert server.control("horn", False) == (light(False, "horn"),)


@pytest.mark.parametrize("how", ["drive", "halt", "control"])
def test_a_new_turn_lets_go_of_all(server: Server, how: str) -> None:
    """A new turn releases everything held, whatever its first message is."""
    server.driving()
    server.control("horn", True)
    server.control("spin", True)
    match how:
        case "drive":
            calls = server.drive(0.5, turn=2)
        case "halt":
            calls = server.halt(turn=2)
        case _:
            calls = server.control("lamp", True, turn=2)
    assert calls[:3] == (StopDriver(2), light(False, "horn", 2), motion("spin", False, 2))
    assert server.warden.turn == 2
    assert server.control("spin", True, turn=2) == ()


def test_letting_go_is_never_refused(server: Server) -> None:
    """A release counts once, however late it is and of whichever turn."""
    server.driving()
    server.control("lift", 1.0)
    assert server.control("lift", None, age_s=60.0, turn=0) == (motion("lift", None),)
    assert server.control("lift", None, age_s=60.0, turn=0) == ()
    server.warden.hold(None, server.now_s)
    assert server.control("spin", False) == (motion("spin", False),)
    assert motion("spin", False).is_release
    assert motion("lift", None).is_release
    assert not motion("lift", 0.0).is_release
