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
from wax.driver.interface import RobotState
from wax.errors import ProtocolError
from wax.robot.process.driver_watchdog import Apply, SetAxis
from wax.robot.process.pipe_messages import (
    LineBuffer,
    Ready,
    StateReport,
    decode_message,
    encode,
    sendable,
)

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.driver.interface import Driver
    from wax.robot.process.driver_watchdog import Call, DriverWatchdog

_LOG = structlog.get_logger(__name__)

BEAT_S: Final = 0.02
TELL_S: Final = 0.05
HUNG_S: Final = 2.0
OPEN_S: Final = 20.0
END_S: Final = 1.0
READ_BYTES: Final = 65_536


class ChildLoop:
    """Makes the watchdog's calls to the driver, at least 50 a second, until the pipe ends.

    `reader` and `writer` are the pipes' descriptors, both non-blocking. A driver whose call takes
    longer than `HUNG_S`, or whose `close` takes longer than `END_S`, ends the process: then the
    robot's own watchdog stops it.
    """

    def __init__(
        self, driver: Driver, watchdog: DriverWatchdog, clock: Clock, *, reader: int, writer: int
    ) -> None:
        self._driver = driver
        self._watchdog = watchdog
        self._clock = clock
        self._reader = reader
        self._writer = writer
        self._lines = LineBuffer()
        self._due_s = clock.now_s()
        self._state = RobotState(connected=False)
        self._said: tuple[object, ...] = ()
        self._said_s = 0.0
        self._unsent = encode(Ready(kind=driver.kind, limits=driver.limits))
        self._logged: str | None = None

    def run(self) -> None:
        """Open the driver, run until the end of the pipe, then stop and close it."""
        try:
            signal.setitimer(signal.ITIMER_REAL, OPEN_S)
            self._driver.open()
            while self._step():
                pass
        finally:
            # An alarm ends the process even if a driver hangs while holding the GIL.
            signal.setitimer(signal.ITIMER_REAL, END_S)
            self._call(*self._watchdog.hold(None, self._clock.now_s()))
            self._driver.close()
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def _step(self) -> bool:
        """Wait for a message, the next tick or silence, and act; False at the end of the pipe."""
        signal.setitimer(signal.ITIMER_REAL, HUNG_S)
        pause_s = min(self._due_s, self._watchdog.silent_at_s) - self._clock.now_s()
        readable, _, _ = select.select([self._reader], [], [], max(0.0, pause_s))
        # Silence first: messages that waited in the pipe while this process slept do not undo it.
        self._call(*self._watchdog.watch(self._clock.now_s()))
        self._look()
        if readable and not self._listen():
            return False
        if self._clock.now_s() >= self._due_s:
            self._call(*self._watchdog.beat(self._clock.now_s()))
        self._look()
        self._log()
        return self._tell()

    def _listen(self) -> bool:
        data = os.read(self._reader, READ_BYTES)
        for line in self._lines.feed(data):
            try:
                message = decode_message(line)
            except ProtocolError:
                self._call(*self._watchdog.garbage(self._clock.now_s()))
            else:
                self._call(*self._watchdog.hear(message, self._clock.now_s()))
        return bool(data)

    def _look(self) -> None:
        """Read the robot's state; a robot that has reconnected begins at standstill."""
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
            try:
                self._one(call)
            except Exception:
                self._failed()

    def _one(self, call: Call) -> None:
        match call:
            case Apply():
                self._due_s = self._clock.now_s() + BEAT_S
                self._driver.apply(call.twist, call.turn)
            case SetAxis():
                self._driver.set_axis(call.name, call.position, call.turn)
            case _:
                self._driver.stop(call.turn)

    def _failed(self) -> None:
        if self._logged != NO_ANSWER:
            _LOG.exception("the robot's driver raised; the robot is stopped")
            self._logged = NO_ANSWER
        for call in self._watchdog.failed(self._clock.now_s()):
            with contextlib.suppress(Exception):  # the failure is already recorded
                self._one(call)

    def _log(self) -> None:
        problem = self._watchdog.problem
        if problem != self._logged:
            self._logged = problem
            if problem is not None:
                _LOG.warning("the robot is held", problem=problem, **self._watchdog.counts)

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
        )


def _facts(state: RobotState) -> tuple[object, ...]:
    """Return the part of a state whose change is sent at once."""
    return (state.connected, state.problem, state.epoch, state.moving)
