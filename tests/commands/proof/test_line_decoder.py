"""Decoding the traffic on the serial line."""

from __future__ import annotations

from wax.commands.proof.line_decoder import language_of
from wax.config.serial import SerialSettings
from wax.robot.serial.frames import (
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)

SESSION = 4711
FRAMES = SerialSettings(dialect="frames")
BYTES = SerialSettings(dialect="bytes")


def words(*bodies: DriveBody | MoveBody | HelloBody | StopBody, session: int = SESSION) -> bytes:
    return b"".join(encode(Frame(body, sequence=n), session) for n, body in enumerate(bodies))


def report(flags: int, session: int = SESSION) -> bytes:
    return encode(Frame(ReportBody(0, 0, 0, 0, flags, 1)), session)


def test_frames_are_motion_or_standstill() -> None:
    """Drives of any wheel are motion at the faster wheel's speed; zero, stop and hello are none."""
    heard = language_of(FRAMES).said(
        words(HelloBody(SESSION), DriveBody(0, -180), DriveBody(0, 0), StopBody()), at_s=1.0
    )
    assert [(event.moves, event.speed_mps) for event in heard] == [
        (False, 0.0),
        (True, 0.18),
        (False, 0.0),
        (False, 0.0),
    ]
    assert {(event.at_s, event.who) for event in heard} == {(1.0, "said")}


def test_a_move_is_as_fast_as_its_vector_is_long() -> None:
    """Ahead and sideways count together; turning on the spot is motion, too."""
    moves = (MoveBody(300, -400, 0), MoveBody(0, 400, 0), MoveBody(0, 0, 9), MoveBody(0, 0, 0))
    heard = language_of(FRAMES).said(words(HelloBody(SESSION), *moves), at_s=1.0)
    assert [(event.moves, event.speed_mps) for event in heard[1:]] == [
        (True, 0.5),
        (True, 0.4),
        (True, 0.0),
        (False, 0.0),
    ]


def test_reports_are_understood_in_the_session_of_the_last_hello() -> None:
    """Only reports in the session of the last hello are decoded."""
    language = language_of(FRAMES)
    assert language.told(report(1), at_s=1.0) == []
    language.said(words(HelloBody(SESSION)), at_s=1.0)
    assert [event.moves for event in language.told(report(1) + report(2), at_s=1.1)] == [
        True,
        False,
    ]
    language.said(words(HelloBody(9), session=9), at_s=2.0)
    assert language.told(report(1), at_s=2.1) == []
    assert [event.moves for event in language.told(report(1, session=9), at_s=2.2)] == [True]


def test_pieces_of_frames_are_put_together() -> None:
    """Frames are decoded wherever their bytes are split."""
    language = language_of(FRAMES)
    whole = words(HelloBody(SESSION), DriveBody(100, 100))
    heard = [event for at, octet in enumerate(whole) for event in language.said(bytes([octet]), at)]
    assert [event.moves for event in heard] == [False, True]


def test_the_last_words_stop_a_robot_of_any_session() -> None:
    """The last words stop a robot in any session."""
    robot = Decoder()
    robot.feed(words(HelloBody(SESSION), DriveBody(100, 100)))
    heard = robot.feed(language_of(FRAMES).last_words())
    assert [type(frame.body) for frame in heard] == [HelloBody, StopBody]


def test_bytes_are_motion_until_the_stop_byte() -> None:
    """Every direction byte is motion, speed bytes are not, and there are no reports."""
    language = language_of(BYTES)
    assert not language.reports
    assert [event.moves for event in language.said(b"1F2LS", at_s=1.0)] == [True, True, False]
    assert language.told(b"whatever", at_s=1.0) == []
    assert language.last_words() == b"S"
