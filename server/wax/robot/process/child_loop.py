"""The driver process's loop: messages from the server in, driver calls and robot states out."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.checks import NO_ANSWER
from wax.driver.interface import HasControls, RobotState
from wax.errors import ProtocolError
from wax.robot.hand.source import LOOK_S
from wax.robot.process.child_start import READ_BYTES
from wax.robot.process.driver_watchdog import Apply, SetAxis, SetControl, StopDriver
from wax.robot.process.pipe_messages import (
    Bye,
    LineBuffer,
    Ready,
    StateReport,
    decode_message,
    encode,
    sendable,
)
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.driver.interface import Driver
    from wax.robot.process.driver_watchdog import Call, DriverWatchdog
    from wax.robot.process.hand_watchdog import HandWatchdog
    from wax.robot.process.passenger import Passenger
    from wax.robot.process.robot_lock import RobotLock

_LOG = structlog.get_logger(__name__)

BEAT_S: Final = 0.02
TELL_S: Final = 0.05
CALL_HANGS_S: Final = 2.0
OPEN_S: Final = 20.0
END_S: Final = 1.0
STILL_DRIVEN: Final = Sentence("aboard.still_drives")
TAKEN: Final = Sentence("robot.taken")


class ChildLoop:
    """Makes the watchdog's calls to the driver, at least 50 a second, until the pipe ends.

    `reader` and `writer` are the pipes' descriptors, both non-blocking. A driver whose call takes
    longer than `CALL_HANGS_S`, or whose `close` takes longer than `END_S`, ends the process: then
    the robot's own watchdog stops it.

    With a `passenger`, their hand control is handled before all messages. If the pipe then ends
    without a `Bye`, they can drive on until another process claims the robot. The robot is not
    opened while another server on this machine holds its `lock`.
    """

    def __init__(
        self,
        driver: Driver,
        watchdog: DriverWatchdog,
        clock: Clock,
        *,
        reader: int,
        writer: int,
        passenger: Passenger | None = None,
        lock: RobotLock | None = None,
    ) -> None:
        self._driver = driver
        self._lock = lock
        self._watchdog: DriverWatchdog | HandWatchdog = (
            watchdog if passenger is None else passenger.watchdog
        )
        self._passenger = passenger
        self._clock = clock
        self._reader = reader
        self._writer = writer
        self._lines = LineBuffer()
        self._due_s = clock.now_s()
        self._state = RobotState(connected=False)
        self._said: tuple[object, ...] = ()
        self._said_s = 0.0
        self._unsent = encode(Ready(kind=driver.kind, limits=watchdog.limits))
        self._logged: Sentence | None = None
        self._broken: set[str] = set()
        self._is_alone = False
        self._is_dismissed = False

    def run(self) -> None:
        """Open the driver, run until the end of the pipe, then stop and close it."""
        if not self._has_robot():
            return
        try:
            signal.setitimer(signal.ITIMER_REAL, OPEN_S)
            self._driver.open()
            if self._passenger is not None:
                self._passenger.open()
            while self._step():
                pass
        finally:
            # An alarm ends the process even if a driver hangs while holding the GIL.
            signal.setitimer(signal.ITIMER_REAL, END_S)
            self._call(*self._watchdog.hold(None, self._clock.now_s()))
            self._driver.close()
            if self._passenger is not None:
                self._passenger.close()
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def _has_robot(self) -> bool:
        """Wait until this process has the robot; return False if the pipe ends first.

        With a person aboard an older process ends once they let go of their control; another
        server's process keeps the robot while it runs.
        """
        passenger, lock = self._passenger, self._lock
        if passenger is not None:
            passenger.claim()
            if not self._waits(passenger.has_robot, STILL_DRIVEN):
                return False
        return lock is None or self._waits(lock.acquire, TAKEN)

    def _waits(self, until: Callable[[], bool], problem: Sentence) -> bool:
        """Wait, and tell the server why; return False if the pipe ends."""
        while not until():
            signal.setitimer(signal.ITIMER_REAL, CALL_HANGS_S)
            self._state = RobotState(connected=False, problem=problem)
            readable, _, _ = select.select([self._reader], [], [], BEAT_S)
            if (readable and not os.read(self._reader, READ_BYTES)) or not self._tell():
                return False
        return True

    def _step(self) -> bool:
        """Wait for input, the next tick or silence, and act; return False to end the loop."""
        signal.setitimer(signal.ITIMER_REAL, CALL_HANGS_S)
        readable = self._wait()
        self._read_hand()
        # Check silence first: messages queued while this process slept must not hide it.
        self._call(*self._watchdog.tick(self._clock.now_s()))
        self._look()
        if self._reader in readable and not self._listen() and not self._is_left_alone():
            return False
        if self._clock.now_s() >= self._due_s:
            self._call(*self._watchdog.repeat(self._clock.now_s()))
        self._look()
        self._log()
        if self._is_alone:
            return self._drives_on()
        return self._tell() or self._is_left_alone()

    def _wait(self) -> list[int]:
        """Wait until something is due, and return the descriptors that can be read."""
        pause_s = min(self._due_s, self._watchdog.silent_at_s) - self._clock.now_s()
        descriptors = [] if self._is_alone else [self._reader]
        if self._passenger is not None:
            if self._passenger.wakes is None:
                pause_s = min(pause_s, LOOK_S)
            else:
                descriptors.append(self._passenger.wakes)
        readable, _, _ = select.select(descriptors, [], [], max(0.0, pause_s))
        return readable

    def _read_hand(self) -> None:
        """Handle the hand control, before any message of the server."""
        if self._passenger is not None:
            self._call(*self._passenger.read())
            self._passenger.remember()  # after the robot is stopped: a disk may be slow

    def _is_left_alone(self) -> bool:
        """Treat the server as dead; return whether the person aboard still needs this process."""
        self._is_alone = True
        if self._passenger is not None and not self._is_dismissed:
            self._call(*self._passenger.watchdog.abandoned(self._clock.now_s()))
        return self._drives_on()

    def _drives_on(self) -> bool:
        """Whether the person aboard still needs this process after its server has died."""
        return (
            self._passenger is not None and not self._is_dismissed and self._passenger.drives_on()
        )

    def _listen(self) -> bool:
        data = os.read(self._reader, READ_BYTES)
        for line in self._lines.feed(data):
            try:
                message = decode_message(line)
            except ProtocolError:
                self._call(*self._watchdog.handle_invalid(self._clock.now_s()))
            else:
                if isinstance(message, Bye):
                    self._is_dismissed = True
                else:
                    self._call(*self._watchdog.handle(message, self._clock.now_s()))
        return bool(data)

    def _look(self) -> None:
        """Read the robot's state; a robot that has reconnected starts at standstill."""
        try:
            state = sendable(self._driver.state())
        except Exception:
            self._failed()
            self._state = replace(self._state, connected=False, problem=NO_ANSWER)
            return
        if state.epoch != self._state.epoch:
            self._call(*self._watchdog.hold(None, self._clock.now_s()))
        self._state = state

    def _call(self, *calls: Call) -> None:
        for call in calls:
            now_s = self._clock.now_s()
            # The last check before the driver: the process may have been frozen since deciding.
            late = self._watchdog.tick(now_s) if _moves(call) else ()
            if late:
                self._call(*late)
            if any(isinstance(one, StopDriver) for one in late):
                return  # the stop released held controls, and the new epoch requests the rest again
            try:
                self._one(call, now_s)
            except Exception:
                if isinstance(call, SetControl) and not call.moves:
                    self._control_failed(call.name)
                else:
                    self._failed()

    def _one(self, call: Call, now_s: float) -> None:
        match call:
            case Apply():
                self._due_s = now_s + BEAT_S
                self._driver.apply(call.twist, call.turn)
            case SetAxis():
                self._driver.set_axis(call.name, call.position, call.turn)
            case SetControl():
                if isinstance(self._driver, HasControls):
                    self._driver.control(call.name, call.value, call.turn)
            case _:
                self._driver.stop(call.turn)

    def _control_failed(self, name: str) -> None:
        """Log the failure, once per control: a failing lamp is no reason to hold the robot."""
        if name not in self._broken:
            _LOG.exception("a control of the robot failed; it drives on", control=name)
            self._broken.add(name)

    def _failed(self) -> None:
        if self._logged != NO_ANSWER:
            _LOG.exception("the robot's driver raised; the robot is stopped")
            self._logged = NO_ANSWER
        now_s = self._clock.now_s()
        for call in self._watchdog.failed(now_s):
            with contextlib.suppress(Exception):  # the failure is already recorded
                self._one(call, now_s)

    def _log(self) -> None:
        problem = self._watchdog.problem
        if problem != self._logged:
            self._logged = problem
            if problem is not None:
                _LOG.warning("the robot is held", problem=str(problem), **self._watchdog.counts)

    def _tell(self) -> bool:
        """Send a changed state to the server at once, and the whole state 20 times a second."""
        now_s = self._clock.now_s()
        state = self._news()
        due = now_s - self._said_s >= TELL_S or _facts(state) != self._said
        if due and not self._unsent:
            self._said, self._said_s = _facts(state), now_s
            self._unsent = encode(StateReport(state=state, counts=self._watchdog.counts))
        try:
            if self._unsent:
                self._unsent = self._unsent[os.write(self._writer, self._unsent) :]
        except BlockingIOError:
            pass  # the pipe is full; the server gets the rest of this line, then the newest state
        except BrokenPipeError:
            return False
        return True

    def _news(self) -> RobotState:
        return replace(
            self._state,
            problem=self._state.problem or self._watchdog.problem,
            epoch=self._state.epoch + self._watchdog.holds,
            aboard=None if self._passenger is None else self._passenger.watchdog.aboard,
        )


def _moves(call: Call) -> bool:
    match call:
        case Apply():
            return not call.twist.is_zero
        case SetAxis():
            return True
        case SetControl():
            return call.moves and not call.is_release
        case _:
            return False


def _facts(state: RobotState) -> tuple[object, ...]:
    """Return the part of a state whose changes are sent at once."""
    return (state.connected, state.problem, state.epoch, state.moving, state.aboard)
