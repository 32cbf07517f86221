"""What every driver on a line decides alike, without threads or io: whom to follow, what to tell.

Each method takes the time and returns at once; a lock makes them safe to call from any thread.
"""

from __future__ import annotations

import threading
from dataclasses import fields
from typing import TYPE_CHECKING

from wax.driver.interface import Reading, RobotState
from wax.robot.line.setpoints import SetPoints

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist
    from wax.robot.line.setpoints import Order
    from wax.sentence import Sentence


class LineCore:
    """Set-points in, orders out; the robot's readings in, its state out.

    The robot is connected from its first reading after `opened` until `lost`. Each connection is a
    new epoch, in which nothing moves until a set-point of standstill.
    """

    def __init__(self, limits: Limits, ttl_s: float) -> None:
        self._lock = threading.Lock()
        self._setpoints = SetPoints(limits, ttl_s)
        self._is_open = self._connected = False
        self._problem: Sentence | None = None
        self._epoch = 0
        self._newest = Reading()

    # --- from the driver --------------------------------------------------------------------

    def apply(self, twist: Twist, turn: int, now_s: float) -> None:
        with self._lock:
            self._setpoints.apply(twist, turn, now_s)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        with self._lock:
            self._setpoints.set_axis(name, position, turn)

    def stop(self, turn: int, now_s: float) -> None:
        with self._lock:
            self._setpoints.stop(turn)
            self._stopped(now_s)

    def state(self, now_s: float) -> RobotState:
        with self._lock:
            reading = self._reading(now_s)
            told = reading if self._connected else Reading(extra=reading.extra)
            return RobotState(
                connected=self._connected,
                problem=self._problem,
                epoch=self._epoch,
                **{one.name: getattr(told, one.name) for one in fields(told)},
            )

    # --- from the line ----------------------------------------------------------------------

    def opened(self, now_s: float) -> None:  # noqa: ARG002 - a core may begin to wait
        """Handle that the line is open: the robot may answer from now on."""
        with self._lock:
            self._is_open = True

    def order(self, now_s: float) -> tuple[Order, float]:
        """Return the order to send now, and when it changes by itself (infinite if never)."""
        with self._lock:
            return self._setpoints.order(now_s)

    def heard(self, reading: Reading | None) -> None:
        """Count as connected, with the robot's answer if it gives one."""
        with self._lock:
            self._newest = reading or self._newest
            self._connect()

    def lost(self, problem: Sentence | None) -> None:
        """Handle that the line was lost, or closed if there is no problem."""
        with self._lock:
            self._is_open = False
            self._disconnect(problem)

    # --- with the lock held -----------------------------------------------------------------

    def _connect(self) -> None:
        if self._is_open and not self._connected:
            self._setpoints.connected()
            self._connected, self._problem = True, None
            self._epoch += 1

    def _disconnect(self, problem: Sentence | None) -> None:
        self._setpoints.lost()
        self._connected, self._problem = False, problem
        self._newest = Reading()

    def _stopped(self, now_s: float) -> None:
        """Handle a stop, if more follows from it than standstill."""

    def _reading(self, now_s: float) -> Reading:  # noqa: ARG002 - readings may grow old
        """Return what the robot tells; while it is not connected, only `extra` counts."""
        return self._newest
