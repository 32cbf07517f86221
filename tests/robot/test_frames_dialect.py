"""Sessions: what the dialect `frames` accepts as an answer, and for how long."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

import pytest
from tests.robot.dialect_robot import Robot, connected, framed, going, says

from wax.config.robot import RobotSettings
from wax.driver.interface import Pose
from wax.robot.serial.frames import NO_SESSION, DriveBody, HelloBody, StopBody
from wax.robot.serial.frames_dialect import FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from collections.abc import Callable


def test_before_the_first_hello_nothing_is_known() -> None:
    """Before a connection there is no answer, and nothing is known of the robot."""
    dialect = framed()
    assert not dialect.answers(0.0)
    assert dialect.overdue(0.5)
    assert dialect.reading.moving is None
    assert dialect.reading.extra == {"line_errors": 0.0}


def test_greetings_have_no_turn_and_no_time_to_live() -> None:
    """Hello and stop carry turn 0 and no time-to-live; hello also carries time 0."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.0, time_ms=5000, sequence=99)  # a report, but no answer
    robot.hear(dialect.data_to_send(going(1, 0), 3.0)[0])
    assert [type(frame.body) for frame in robot.heard] == [HelloBody, StopBody, HelloBody, StopBody]
    assert {(frame.turn, frame.ttl_ms) for frame in robot.heard} == {(0, 0)}
    assert [frame.time_ms for frame in robot.heard] == [0, 0, 0, 7000]


@pytest.mark.parametrize(("answered_s", "number"), [(1.1, 99), (1.5, 2)])
def test_a_report_that_is_no_answer_changes_nothing(answered_s: float, number: int) -> None:
    """The same session is offered until one of its frames is acknowledged in time."""
    dialect, robot = framed(), Robot()
    hello = robot.hear(dialect.hello(1.0))
    robot.answer(dialect, answered_s, sequence=number)
    for now_s in (1.5, 1.625, 1.75):
        assert robot.hear(dialect.data_to_send(going(1, 0), now_s)[0]) == hello
    robot.answer(dialect, 1.75)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.76)[0]) == [DriveBody(600, 600)]


def test_a_frame_of_the_last_session_is_no_answer() -> None:
    """Frames from before the newest hello no longer count."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    before = robot.heard[-1].sequence
    robot.hear(dialect.hello(1.1))
    robot.answer(dialect, 1.1, sequence=before)
    assert not dialect.answers(1.1)
    robot.answer(dialect, 1.1)
    assert dialect.answers(1.1)


def test_a_robot_that_keeps_answering_keeps_its_session() -> None:
    """An answer counts for 0.5 s after the frame that it acknowledges was sent."""
    dialect, robot = connected(1.0)
    session = robot.decoder.session
    for number in range(1, 21):
        robot.hear(dialect.data_to_send(going(1, 0), 1.0 + number / 10)[0])
        robot.answer(dialect, 1.05 + number / 10)
    assert robot.decoder.session == session
    assert (dialect.answers(3.49), dialect.answers(3.5)) == (True, False)
    assert (dialect.overdue(3.49), dialect.overdue(3.5)) == (False, True)


def test_a_robot_that_lags_behind_does_not_answer() -> None:
    """A report must acknowledge one of the last 256 frames, however recent."""
    for behind, hears in ((255, True), (256, False)):
        dialect, robot = connected(1.0)
        for number in range(300):
            robot.hear(dialect.data_to_send(going(1 if number % 2 else -1, 0), 1.4)[0])
        robot.answer(dialect, 1.4, sequence=robot.heard[-1].sequence - behind)
        assert dialect.answers(1.5) is hears


def test_after_a_silence_motion_is_sent_at_once() -> None:
    """In a new session even an unchanged order counts as new."""
    dialect, robot = connected(1.0)
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    robot.hear(dialect.data_to_send(going(1, 0), 1.5)[0])
    robot.answer(dialect, 1.51)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.52)[0]) == [DriveBody(600, 600)]


def test_a_turn_that_begins_with_motion_begins_with_a_stop() -> None:
    """If the stop between two turns was not sent, it is sent first, but never twice."""
    dialect, robot = connected(1.0)
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    assert robot.hear(dialect.data_to_send(going(-1, 0, turn=2), 1.01)[0]) == [
        StopBody(),
        DriveBody(-600, -600),
    ]
    assert robot.heard[-2].turn == 2
    assert robot.hear(dialect.data_to_send(going(0, 0, turn=3), 1.02)[0]) == [StopBody()]
    assert robot.hear(dialect.data_to_send(going(1, 0, turn=3), 1.03)[0]) == [DriveBody(600, 600)]


def test_a_robot_that_stopped_by_itself_does_not_resume_by_itself() -> None:
    """After its own watchdog has stopped it, a new session begins, although it answers."""
    dialect, robot = connected(1.0)
    session = robot.decoder.session
    robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0])
    robot.answer(dialect, 1.2, flags=2)
    assert not dialect.answers(1.2)
    assert dialect.overdue(1.2)
    assert [type(body) for body in robot.hear(dialect.data_to_send(going(1, 0), 1.21)[0])] == [
        HelloBody,
        StopBody,
    ]
    assert robot.decoder.session != session
    robot.answer(dialect, 1.22)
    assert dialect.answers(1.22)


def test_an_earlier_stop_by_its_watchdog_is_ignored() -> None:
    """A session's first report may still say that the watchdog has stopped the robot."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.1, flags=2)
    assert dialect.answers(1.1)


def test_ticks_of_known_length_give_the_pose() -> None:
    """Speed is by the robot's clock, even when it wraps; a new session continues the pose."""
    settings = RobotSettings.model_validate({"serial": {"ticks_per_m": 1000.0}})
    dialect = FramesDialect(WheelMixer(settings), 200, (), Odometry(settings))
    robot = Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.0, time_ms=2**32 - 100)
    assert dialect.reading.pose is None
    assert "left_mps" not in dialect.reading.extra
    robot.answer(dialect, 9.0, time_ms=100, left_ticks=100, right_ticks=100)
    assert dialect.reading.pose == Pose(0.1, 0.0, 0.0)
    assert dialect.reading.extra["left_mps"] == pytest.approx(0.5)
    robot.hear(dialect.hello(10.0))
    assert dialect.reading.pose is None
    robot.answer(dialect, 10.0, time_ms=5, left_ticks=7, right_ticks=7)
    robot.answer(dialect, 10.1, time_ms=105, left_ticks=107, right_ticks=107)
    assert dialect.reading.pose == Pose(0.2, 0.0, 0.0)


def test_farewell_before_any_motion() -> None:
    """Before any turn the farewell has turn 0."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    assert robot.hear(dialect.farewell()) == [StopBody()]
    assert robot.heard[-1].turn == 0


def test_without_an_answer_greetings_keep_their_rate() -> None:
    """Without an answer, hello and stop are sent ten times a second, no more often."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    robot.hear(dialect.data_to_send(going(1, 0), 2.0)[0])
    assert says(dialect, going(-1, 0), 2.05) == (b"", 2.1)


@pytest.fixture
def draws(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], list[int]]:
    """Draw always the same number; return the ranges from which it was drawn."""
    drawn_from: list[int] = []

    def rig(number: int) -> list[int]:
        def draw(below: int) -> int:
            drawn_from.append(below)
            return number

        monkeypatch.setattr(secrets, "randbelow", draw)
        return drawn_from

    return rig


def test_sessions_are_drawn_from_the_whole_range(draws: Callable[[int], list[int]]) -> None:
    """They are 1 to 65533, and 65534 in place of the last one."""
    drawn_from = draws(0)
    dialect, robot = framed(), Robot()
    sessions = [robot.hear(dialect.hello(float(n)))[0] for n in range(3)]
    assert sessions == [HelloBody(1), HelloBody(65_534), HelloBody(1)]
    assert set(drawn_from) == {65_533}
    draws(65_532)
    assert robot.hear(dialect.hello(9.0))[0] == HelloBody(65_533)
    assert NO_SESSION == 65_535
