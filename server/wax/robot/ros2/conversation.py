"""The messages to and from a ROS 2 robot, without threads and wire format."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from wax.driver.interface import RobotState
from wax.robot.line.setpoints import SetPoints
from wax.robot.ros2.pace import Pace
from wax.robot.ros2.senses import RosSenses
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist
    from wax.robot.ros2.settings import Ros2Settings


class Ros2Conversation:
    """Set-points in, messages out; messages in, the robot's state out; thread-safe.

    While the `verdict` says why the robot cannot be driven, it counts as not connected and only
    standstill is sent. A new connection begins at standstill and with a new epoch.
    """

    def __init__(self, settings: Ros2Settings, limits: Limits) -> None:
        self._lock = threading.Lock()
        self._setpoints = SetPoints(limits, settings.ttl_ms / 1000.0)
        self._pace = Pace(
            rate_hz=settings.rate_hz, zeros_s=settings.zeros_s, idle_hz=settings.idle_hz
        )
        self._senses = RosSenses()
        self._connected = False
        self._verdict: Sentence | None = None
        self._is_alone = True
        self._epoch = 0
        self._ttl_s: float | None = None

    def apply(self, twist: Twist, turn: int, now_s: float) -> None:
        with self._lock:
            self._setpoints.apply(twist, turn, now_s)

    def stop(self, turn: int, now_s: float) -> None:
        """Send standstill for its full duration, even if others publish, too."""
        with self._lock:
            self._setpoints.stop(turn)
            self._pace.stopped(now_s)

    def opened(self) -> None:
        """Handle a new connection: standstill is sent first, for its full duration."""
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
            if verdict is not None:
                self._disconnect(verdict)
            elif not self._connected:
                self._setpoints.connected()
                self._connected, self._verdict = True, None
                self._epoch += 1

    def promised(self, ttl_s: float | None) -> None:
        """Set the timeout after which the robot says that it stops by itself, 0 if never."""
        with self._lock:
            self._ttl_s = ttl_s

    def lost(self, why: Sentence | None) -> None:
        """Handle the loss of the connection; the problem is None if we closed it."""
        with self._lock:
            self._disconnect(why)
            self._ttl_s = None

    def state(self, now_s: float) -> RobotState:
        with self._lock:
            senses, connected = self._senses, self._connected
            fault = senses.fault(now_s)
            problem, ttl_s = self._verdict, self._ttl_s
            extra = {} if ttl_s is None else {"ros2_timeout_s": ttl_s}
            if problem is None and fault is not None and connected:
                problem = Sentence("ros2.fault", {"fault": fault})
            return RobotState(
                connected=connected,
                problem=problem,
                epoch=self._epoch,
                moving=senses.moving(now_s) if connected else None,
                pose=senses.pose(now_s) if connected else None,
                bumpers=senses.bumpers if connected else 0,
                battery_v=senses.battery_v if connected else None,
                battery_fraction=senses.battery_fraction if connected else None,
                ttl_s=ttl_s,
                extra=extra | {"ros2_invalid": float(senses.invalid)},
            )

    def _disconnect(self, why: Sentence | None) -> None:
        self._setpoints.lost()
        self._connected, self._verdict = False, why
