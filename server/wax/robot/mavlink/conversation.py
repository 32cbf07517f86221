"""The messages to and from the rover."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.interface import STANDSTILL, Reading
from wax.robot.line.core import LineCore
from wax.robot.mavlink.codec import Codec
from wax.robot.mavlink.failsafe import warnings
from wax.robot.mavlink.mapping import sticks, velocity
from wax.robot.mavlink.questions import Questions
from wax.robot.mavlink.rover import Rover
from wax.robot.mavlink.schedule import Schedule

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.driver.interface import Limits, Twist
    from wax.robot.mavlink.settings import MavlinkSettings
    from wax.sentence import Sentence

_LOG = structlog.get_logger(__name__)

SETPOINT_TTL_S: Final = 0.2
"""The driver's process repeats the set-point 50 times a second."""
HEARTBEAT_EVERY_S: Final = 1.0
FAREWELL_S: Final = 0.4
"""How long standstill is sent before closing the line, which may take a second at most."""


class Conversation(LineCore):
    """Set-points in, MAVLink out; MAVLink in, the robot's state out.

    The robot is connected while the rover's messages arrive and its failsafe is known. It is
    *ready* while the rover is also in the right mode, armed and obeys us. Set-points are sent only
    then; each time it becomes ready, nothing moves until a set-point of standstill.
    """

    def __init__(
        self, settings: MavlinkSettings, limits: Limits, clock: Clock, key: bytes | None
    ) -> None:
        super().__init__(limits, SETPOINT_TTL_S)
        self._settings = settings
        self._limits = limits
        self._codec = Codec(settings.own_system, settings.system, key, clock.wall_ms())
        self._rover = Rover(settings)
        self._questions = Questions(settings.telemetry_hz)
        self._schedule = Schedule(1.0 / settings.command_hz)
        self._beat_s = -math.inf
        self._refused_before = 0
        self._ready = self._has_driven = self._is_leaving = False
        self._said_motion = False

    def start(self) -> None:
        """Begin: the driver was opened, and no rover follows us yet."""
        with self._lock:
            self._has_driven = False

    def opened(self, now_s: float) -> None:
        """Handle that the line is open; the rover may still follow the last set-point."""
        with self._lock:
            self._codec.forget()
            self._refused_before = self._codec.refused
            self._beat_s = -math.inf
            self._is_leaving = False
            self._schedule.begin()
            if self._has_driven:
                self._schedule.stopped(now_s)
            self._begin(now_s)
            self._look(now_s)

    def next(self, now_s: float) -> tuple[bytes, float, bool]:
        """Return the bytes to send now, the latest time of the next call, and whether it is a stop.

        Only the first standstill after motion counts as a stop.
        """
        with self._lock:
            self._look(now_s)
            words = b""
            if now_s >= self._beat_s:
                words, self._beat_s = self._codec.heartbeat(), now_s + HEARTBEAT_EVERY_S
            for name in self._questions.parameters(self._rover, now_s):
                words += self._codec.ask_parameter(name)
            for number, rate_hz in self._questions.telemetry(self._rover, now_s):
                words += self._codec.ask_telemetry(number, rate_hz)
            had_said_motion = self._said_motion
            told, due_s = self._tell(now_s)
            changes_s = (self._rover.silent_at_s, self._rover.asks_end_s)
            due_s = min(
                due_s,
                self._beat_s,
                self._questions.next_s(self._rover, now_s),
                *(at_s for at_s in changes_s if at_s > now_s),
            )
            return words + told, due_s, had_said_motion and not self._said_motion

    def received(self, data: bytes, now_s: float) -> bool:
        """Handle received bytes; return whether any are from the rover."""
        with self._lock:
            was_there = self._rover.answers(now_s)
            heard = [self._rover.handle_message(heard, now_s) for heard in self._codec.feed(data)]
            if self._rover.restarted:
                self._disconnect(None)
                self._begin(now_s)
            if not was_there and self._rover.answers(now_s):
                self._beat_s = -math.inf  # send it a heartbeat at once
            self._look(now_s)
            return any(heard)

    def last_words(self, now_s: float) -> bytes:
        """Return standstill for a closing line, nothing for a rover that somebody else drives."""
        with self._lock:
            return self._words(STANDSTILL, now_s) if self._may_tell(now_s) else b""

    def lost(self, problem: Sentence | None) -> None:
        super().lost(problem)
        with self._lock:
            self._rover.begin(math.inf)

    def farewell(self, now_s: float) -> float:
        """Send only standstill from now on; return for how long, before the line is closed."""
        with self._lock:
            self._is_leaving = True
            self._retire()
            self._schedule.stopped(now_s)
            return FAREWELL_S if self._has_driven else 0.0

    # --- with the lock held -----------------------------------------------------------------

    def _begin(self, now_s: float) -> None:
        self._rover.begin(now_s)
        self._questions.begin()

    def _look(self, now_s: float) -> None:
        """Update whether the rover is connected, and ready."""
        rover = self._rover
        absent = rover.absent(now_s, self._codec.refused - self._refused_before)
        if absent is not None:
            if self._connected:
                self._schedule.stopped(now_s)  # the sending direction may still work
                self._disconnect(absent)
                self._begin(now_s - math.inf)
            self._problem = absent
            return
        if not self._connected:
            self._connected = True
            self._epoch += 1
            for line in warnings(rover.promise):
                _LOG.warning(line, system=self._settings.system)
        self._problem = rover.unfit()
        if self._problem is not None:
            if self._ready:
                self._schedule.stopped(now_s)
            self._retire()
        elif not self._ready and not self._is_leaving:
            self._ready = self._has_driven = True
            self._epoch += 1
            self._setpoints.connected()
            self._schedule.stopped(now_s)

    def _tell(self, now_s: float) -> tuple[bytes, float]:
        """Return the set-point if it is due, and when the next one is."""
        schedule = self._schedule
        wanted, changes_s = STANDSTILL, math.inf
        if self._ready:
            order, changes_s = self._setpoints.order(now_s)
            wanted = order.twist
        elif not self._may_tell(now_s):
            return b"", math.inf
        words = b""
        if schedule.next_s(wanted, now_s) <= now_s:
            schedule.said(wanted, now_s)
            self._said_motion = not wanted.is_zero
            words = self._words(wanted, now_s)
        return words, min(changes_s, schedule.next_s(wanted, now_s))

    def _may_tell(self, now_s: float) -> bool:
        if not self._has_driven:
            return False
        # In another mode somebody may be driving by transmitter: do not interfere.
        return self._ready or not self._connected or self._schedule.is_steady(now_s)

    def _words(self, wanted: Twist, now_s: float) -> bytes:
        if self._settings.mode == "guided":
            return self._codec.velocity(velocity(wanted, self._limits), now_s)
        return self._codec.sticks(sticks(wanted, self._limits))

    def _disconnect(self, problem: Sentence | None) -> None:
        self._ready = False
        super()._disconnect(problem)

    def _stopped(self, now_s: float) -> None:
        self._schedule.stopped(now_s)

    def _reading(self, now_s: float) -> Reading:  # noqa: ARG002 - of the base class
        rover, codec = self._rover, self._codec
        counts = {"line_errors": float(codec.damaged), "line_refused": float(codec.refused)}
        return Reading(
            moving=rover.moving,
            pose=rover.pose,
            battery_v=rover.battery.volts,
            battery_fraction=rover.battery.fraction,
            ttl_s=rover.told_s,
            extra=rover.known() | counts,
        )

    def _retire(self) -> None:
        self._ready = False
        self._setpoints.lost()
