"""The messages between the server and the driver process, line by line."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from wax.config.controls import ControlSettings
from wax.config.local import ActSettings, LocalSettings
from wax.config.log import LogSettings
from wax.config.robot import RobotSettings
from wax.driver.interface import Aboard, Limits, RobotState
from wax.errors import ProtocolError
from wax.robot.process.pipe_messages import (
    MAX_LINE_BYTES,
    Axis,
    Begin,
    Bye,
    Control,
    Halt,
    LineBuffer,
    Message,
    Move,
    Ready,
    StateReport,
    decode_answer,
    decode_begin,
    decode_message,
    encode,
    sendable,
)

MOVE = Move(sequence=1, sent_s=2.5, turn=3, linear_mps=0.5, angular_rps=-1.0)
CONTROLS = [
    ControlSettings(name="lamp", kind="toggle"),
    ControlSettings(name="lift", kind="slider", moves=True),
    ControlSettings(name="light", kind="choice", choices=["white", "red"]),
]
SAID: tuple[Message, ...] = (
    MOVE,
    MOVE.model_copy(update={"lateral_mps": -0.25}),
    Axis(sequence=2**63, sent_s=-1.0, turn=0, name="pan", position=-1.0),
    Axis(sequence=0, sent_s=0.0, turn=2**63, name="pan", position=1.0),
    Halt(sequence=2, sent_s=2.6, turn=3),
    *[
        Control(sequence=3, sent_s=2.7, turn=3, name="lamp", value=value)
        for value in (True, False, 0.0, 1.0, 7.5, "white", "", None)
    ],
)


def test_what_is_said_is_heard() -> None:
    """Each message is one line, and is decoded as it was encoded."""
    for said in SAID:
        assert repr(decode_message(encode(said))) == repr(said)
    assert decode_message(encode(Bye())) == Bye()
    local = LocalSettings(source="robot", script=[ActSettings(at_s=1.0, press="stop")])
    for begin in (
        Begin(robot=RobotSettings(), log=LogSettings()),
        Begin(robot=RobotSettings(), log=LogSettings(), local=local, claim="/tmp/claim"),
        Begin(robot=RobotSettings(), log=LogSettings(), controls=CONTROLS),
    ):
        assert decode_begin(encode(begin)) == begin
    limits = Limits(0.5, 1.0, ("pan",), controls=("lamp",), lateral_mps=0.5)
    ready = Ready(kind="frames", limits=limits)
    assert decode_answer(encode(ready)) == ready
    told = StateReport(
        state=RobotState(
            connected=True,
            battery_fraction=0.5,
            aboard=Aboard("hand", 0.0, "wait", 2),
            gauges={"motor_c": 40.5},
            ttl_s=0.5,
        ),
        counts={"line.lost": 2},
    )
    assert decode_answer(encode(told)) == told
    assert all(encode(said).count(b"\n") == 1 == encode(said)[-1:].count(b"\n") for said in SAID)


def test_what_was_said_stays_said() -> None:
    """Messages are immutable."""
    said = MOVE.model_copy()
    with pytest.raises(ValidationError):
        said.turn = 4
    assert said == MOVE


@pytest.mark.parametrize("speed_mps", [math.nan, math.inf, -math.inf])
def test_a_speed_that_is_none_is_let_through(speed_mps: float) -> None:
    """A NaN speed is accepted, for the watchdog turns it into standstill."""
    for name in ("linear_mps", "angular_rps", "lateral_mps"):
        read = decode_message(encode(MOVE.model_copy(update={name: speed_mps})))
        assert isinstance(read, Move)
        assert repr(getattr(read, name)) == repr(speed_mps)


def without(key: str) -> dict[str, object]:
    return {name: value for name, value in MOVE.model_dump().items() if name != key}


def test_a_move_without_a_speed_sideways_has_none() -> None:
    """A set-point that says nothing of it moves the robot ahead and round only."""
    read = decode_message(json.dumps(without("lateral_mps")).encode())
    assert isinstance(read, Move)
    assert read.lateral_mps == 0.0


def test_a_move_without_a_word_of_it_has_an_operator() -> None:
    """A set-point that does not say so is an operator's."""
    read = decode_message(json.dumps(without("operated")).encode())
    assert isinstance(read, Move)
    assert read.operated


WRONG = {
    "nothing": b"",
    "no JSON": b"halt",
    "no object": b"[]",
    "another word": json.dumps(MOVE.model_dump() | {"say": "fly"}).encode(),
    "no word": json.dumps(without("say")).encode(),
    "no sequence": json.dumps(without("sequence")).encode(),
    "no turn": json.dumps(without("turn")).encode(),
    "no time": json.dumps(without("sent_s")).encode(),
    "no speed": json.dumps(without("angular_rps")).encode(),
    "a key too many": json.dumps(MOVE.model_dump() | {"wheels": 4}).encode(),
    "a sequence below 0": json.dumps(MOVE.model_dump() | {"sequence": -1}).encode(),
    "a sequence too high": json.dumps(MOVE.model_dump() | {"sequence": 2**63 + 1}).encode(),
    "a text for a number": json.dumps(MOVE.model_dump() | {"linear_mps": "0.5"}).encode(),
    "a time that is none": json.dumps(MOVE.model_dump() | {"sent_s": math.nan}).encode(),
    "an axis too far": encode(SAID[2]).replace(b"-1.0,", b"-1.01,").replace(b":-1.0}", b":-1.01}"),
    "an answer": encode(StateReport(state=RobotState(connected=True), counts={})),
    "too long": encode(MOVE)[:-1] + b" " * MAX_LINE_BYTES,
}


@pytest.mark.parametrize("line", WRONG.values(), ids=WRONG)
def test_what_is_none_of_ours_is_refused(line: bytes) -> None:
    """A line with any error is refused with a reason."""
    with pytest.raises(ProtocolError, match="invalid message"):
        decode_message(line)


def test_an_answer_and_a_beginning_are_held_to_it_too() -> None:
    """Neither side accepts a line meant for the other."""
    for decode in (decode_answer, decode_begin):
        with pytest.raises(ProtocolError, match="invalid message: "):
            decode(encode(MOVE))
    with pytest.raises(ProtocolError, match="invalid message: "):
        decode_answer(b'{"state":{"connected":true},"counts":{}}')  # without its word


@given(st.binary(max_size=200))
def test_bytes_that_nobody_wrote_are_refused(line: bytes) -> None:
    """Whatever comes down the pipe is a message or `ProtocolError`, nothing else."""
    with pytest.raises(ProtocolError):
        decode_message(line)


@given(st.lists(st.sampled_from(SAID), max_size=5), st.data())
def test_lines_are_the_same_however_they_are_cut(said: list[Message], data: st.DataObject) -> None:
    """The pipe may split lines anywhere; an incomplete line waits for its end."""
    stream = b"".join(map(encode, said)) + b'{"say":"ha'
    lines, heard = LineBuffer(), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        heard += lines.feed(stream[:size])
        stream = stream[size:]
    assert [decode_message(line) for line in heard] == said


def test_a_line_that_never_ends_is_kept_no_longer_than_it_may() -> None:
    """An overlong line uses bounded memory and is refused at its end, and the next one counts."""
    lines = LineBuffer()
    for _ in range(100):
        assert lines.feed(b" " * MAX_LINE_BYTES) == []
    line, following = lines.feed(b"\n" + encode(MOVE))
    assert len(line) == MAX_LINE_BYTES + 1
    with pytest.raises(ProtocolError, match="too long"):
        decode_message(line)
    assert decode_message(following) == MOVE


def test_the_longest_line_is_read() -> None:
    """A line of the maximum length is accepted."""
    line = encode(MOVE)[:-1]
    assert decode_message(line + b" " * (MAX_LINE_BYTES - len(line))) == MOVE


def test_a_state_that_cannot_be_told_is_refused() -> None:
    """A plug-in may return anything; a state that the server could not read is refused."""
    state = RobotState(connected=True, battery_fraction=0.5)
    assert sendable(state) == state
    with pytest.raises(TypeError, match="returned None, not a RobotState"):
        sendable(None)
    for wrong in ({"connected": "yes"}, {"connected": True, "battery_fraction": "full"}):
        with pytest.raises(ValueError, match="validation error"):
            sendable(RobotState(**wrong))
