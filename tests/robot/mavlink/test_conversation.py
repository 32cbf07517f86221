"""What is sent to a rover when its line is lost and reopened."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Final

import pytest
from pymavlink.dialects.v20 import common as mavlink
from tests.turned_clock import TurnedClock

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Limits, RobotState, Twist
from wax.robot.line.kept_line import KeptLine
from wax.robot.mavlink.conversation import Conversation
from wax.robot.mavlink.link import MavlinkLink
from wax.robot.mavlink.settings import MavlinkSettings

if TYPE_CHECKING:
    from collections.abc import Callable

AHEAD: Final = Twist(0.3, 0.0)
PARAMETERS: Final = {
    "FS_GCS_ENABLE": 1.0,
    "FS_GCS_TIMEOUT": 1.0,
    "FS_TIMEOUT": 0.5,
    "FS_ACTION": 2.0,
    "FS_THR_ENABLE": 1.0,
    "GUID_TIMEOUT": 1.0,
    "SYSID_MYGCS": 255.0,
}
LIMITS: Final = Limits(0.6, 1.5)
SETTINGS: Final = MavlinkSettings.model_validate({"url": "/dev/radio", "reopen_s": 0.05})


def rover(mode: int = 15) -> bytes:
    """Return the messages of a rover that is ready to be driven."""
    mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    messages = [mavlink.MAVLink_heartbeat_message(10, 3, 128 | 1, mode, 4, 3)]
    messages += [
        mavlink.MAVLink_param_value_message(name.encode(), value, 9, 7, index)
        for index, (name, value) in enumerate(PARAMETERS.items())
    ]
    return b"".join(message.pack(mav) for message in messages)


def speeds(words: bytes) -> list[float]:
    """Return the speeds in these messages."""
    heard = mavlink.MAVLink(None).parse_buffer(words) or ()
    kind = mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
    return [message.vx for message in heard if message.get_msgId() == kind]


def started(clock: TurnedClock) -> Conversation:
    talk = Conversation(SETTINGS, LIMITS, clock, None)
    talk.start()
    talk.opened(clock.time_s)
    return talk


def driving(clock: TurnedClock) -> Conversation:
    """Return a conversation that has just sent motion."""
    talk = started(clock)
    talk.received(rover(), clock.time_s)
    assert speeds(talk.next(clock.time_s)[0]) == [0.0]
    for twist in (STANDSTILL, AHEAD):
        talk.apply(twist, 1, clock.time_s)
    clock.time_s += 0.1
    assert speeds(talk.next(clock.time_s)[0]) == [pytest.approx(AHEAD.linear_mps)]
    return talk


def test_only_the_first_standstill_after_motion_is_a_stop() -> None:
    """A repeated stop must not discard the one before, which a slow line is still sending."""
    clock = TurnedClock()
    talk = driving(clock)
    clock.time_s += 0.02
    talk.stop(1, clock.time_s)
    words, due_s, is_stop = talk.next(clock.time_s)
    assert (speeds(words), is_stop) == ([0.0], True)
    for _ in range(50):
        clock.time_s = due_s
        talk.stop(1, clock.time_s)
        _, due_s, is_stop = talk.next(clock.time_s)
        assert not is_stop
        due_s = max(due_s, clock.time_s + 0.02)


def test_a_reopened_line_stops_the_rover_at_once() -> None:
    """A reopened line sends a stop at once, as the rover may still be moving."""
    clock = TurnedClock()
    talk = driving(clock)
    talk.lost(None)
    clock.time_s += 0.5
    talk.opened(clock.time_s)
    words, due_s, _ = talk.next(clock.time_s)
    assert speeds(words) == [0.0]
    assert due_s - clock.time_s == pytest.approx(1.0 / SETTINGS.command_hz)
    assert not talk.state(clock.time_s).connected
    for _ in range(50):
        clock.time_s += 0.02
        talk.apply(AHEAD, 1, clock.time_s)
        assert speeds(talk.next(clock.time_s)[0]) in ([0.0], [])
    assert speeds(talk.last_words(clock.time_s)) == [0.0]


def test_a_rover_that_was_never_driven_is_not_disturbed() -> None:
    """Without motion, no line sends it a set-point, open or lost: a person may drive it."""
    clock = TurnedClock()
    talk = started(clock)
    for _ in range(2):
        talk.received(rover(mode=0), clock.time_s)
        assert speeds(talk.next(clock.time_s)[0]) == []
        assert talk.last_words(clock.time_s) == b""
        talk.lost(None)
        clock.time_s += 0.5
        talk.opened(clock.time_s)
        assert speeds(talk.next(clock.time_s)[0]) == []


def test_a_person_who_has_taken_the_rover_keeps_it_when_the_line_is_lost() -> None:
    """After the mode has changed, standstill is sent for a while only."""
    clock = TurnedClock()
    talk = driving(clock)
    talk.received(rover(mode=0), clock.time_s)
    assert speeds(talk.last_words(clock.time_s)) == [0.0]
    clock.time_s += 2.4
    assert talk.state(clock.time_s).connected
    assert talk.last_words(clock.time_s) == b""


def test_a_reopened_driver_sends_nothing_before_it_drives() -> None:
    """Since the farewell, somebody else may have taken the rover."""
    clock = TurnedClock()
    talk = driving(clock)
    talk.lost(None)
    talk.start()
    talk.opened(clock.time_s)
    assert speeds(talk.next(clock.time_s)[0]) == []


def is_ready(state: RobotState) -> bool:
    return state.connected and state.problem is None


class Line:
    """A line whose reader can fail while what is written still arrives."""

    def __init__(self) -> None:
        self.said = b""
        self.closed = False
        self.stops = 0
        self.breaks = threading.Event()
        self._hears = rover()

    def read(self) -> bytes:
        if self.breaks.wait(0.005):
            raise OSError("broken")
        hears, self._hears = self._hears, b""
        return hears

    def answer(self) -> None:
        """Do nothing: there is one peer."""

    def write(self, data: bytes) -> None:
        assert not self.closed
        self.said += data

    def stop(self, data: bytes) -> None:
        self.stops += 1
        self.write(data)

    def close(self) -> None:
        self.closed = True


def test_a_stop_is_sent_on_a_line_that_can_only_be_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """When the reader fails, the rover gets a stop before its own timeout."""
    lines: list[Line] = []

    def open_line(_: MavlinkSettings) -> Line:
        lines.append(Line())
        return lines[-1]

    monkeypatch.setattr("wax.robot.mavlink.link.open_line", open_line)
    clock = SystemClock()
    talk = Conversation(SETTINGS, LIMITS, clock, None)
    link = MavlinkLink(SETTINGS, clock, talk)
    kept = KeptLine("mavlink", link, talk, clock, reopen_s=SETTINGS.reopen_s)

    def until(so: Callable[[], bool], wanted: Twist = AHEAD) -> None:
        end_s = time.monotonic() + 10.0
        while not so():
            assert time.monotonic() < end_s
            talk.apply(wanted, 1, clock.now_s())
            kept.wake()
            time.sleep(0.01)

    kept.open()
    try:
        until(lambda: is_ready(talk.state(clock.now_s())))
        talk.apply(STANDSTILL, 1, clock.now_s())
        until(lambda: speeds(lines[0].said)[-1:] > [0.0])
        stops = lines[0].stops
        until(lambda: lines[0].stops > stops, STANDSTILL)
        until(lambda: speeds(lines[0].said)[-1:] > [0.0])
        lines[0].breaks.set()
        until(lambda: len(lines) > 1)
        assert speeds(lines[0].said)[-1] == 0.0
    finally:
        kept.close()
