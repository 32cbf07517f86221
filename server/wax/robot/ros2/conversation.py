"""The messages to and from a ROS 2 robot, without threads and wire format."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from wax.robot.line.core import LineCore
from wax.robot.ros2.pace import Pace
from wax.robot.ros2.senses import RosSenses
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Reading, RobotState, Twist
    from wax.robot.ros2.settings import Ros2Settings


class Ros2Conversation(LineCore):
    """Set-points in, messages out; messages in, the robot's state out.

    While the verdict says why the robot cannot be driven, it counts as not connected and only
    standstill is sent. A new connection begins at standstill and with a new epoch.
    """

    def __init__(self, settings: Ros2Settings, limits: Limits) -> None:
        super().__init__(limits, settings.ttl_ms / 1000.0)
        self._pace = Pace(
            rate_hz=settings.rate_hz, zeros_s=settings.zeros_s, idle_hz=settings.idle_hz
        )
        self._senses = RosSenses()
        self._is_alone = True
        self._ttl_s: float | None = None

    def opened(self, now_s: float) -> None:
        """Handle a new connection: standstill is sent first, for its full duration."""
        super().opened(now_s)
        with self._lock:
            self._pace.begin()

    def next(self, now_s: float) -> tuple[Twist | None, float]:
        """Return the twist to send now, None for nothing, and the latest time of the next call."""
        with self._lock:
            order, changes_s = self._setpoints.order(now_s)
            is_due, again_s = self._pace.next(order.twist, now_s, alone=self._is_alone)
            return order.twist if is_due else None, min(again_s, changes_s)

    def owes(self, now_s: float) -> bool:
        """Whether the robot moves, or standstill has not been sent for long enough."""
        with self._lock:
            return self._pace.owes(now_s)

    def handle_message(self, kind: str, message: Any, now_s: float) -> None:
        with self._lock:
            self._senses.handle_message(kind, message, now_s)

    def judged(self, verdict: Sentence | None, *, alone: bool) -> None:
        """Set why the robot cannot be driven, None if it can, and whether we publish alone."""
        with self._lock:
            self._is_alone = alone
            if verdict is None:
                self._connect()
            else:
                self._disconnect(verdict)

    def promised(self, ttl_s: float | None) -> None:
        """Set the timeout after which the robot says that it stops by itself, 0 if never."""
        with self._lock:
            self._ttl_s = ttl_s

    def lost(self, problem: Sentence | None) -> None:
        super().lost(problem)
        self.promised(None)

    def state(self, now_s: float) -> RobotState:
        state = super().state(now_s)
        with self._lock:
            fault, ttl_s = self._senses.fault(now_s), self._ttl_s
        if state.connected and fault is not None:
            state = replace(state, problem=Sentence("ros2.fault", {"fault": fault}))
        return replace(state, ttl_s=ttl_s)

    # --- with the lock held -----------------------------------------------------------------

    def _stopped(self, now_s: float) -> None:
        """Send standstill for its full duration, even if others publish, too."""
        self._pace.stopped(now_s)

    def _reading(self, now_s: float) -> Reading:
        reading = self._senses.reading(now_s)
        if self._ttl_s is None:
            return reading
        return replace(reading, extra=reading.extra | {"ros2_timeout_s": self._ttl_s})
