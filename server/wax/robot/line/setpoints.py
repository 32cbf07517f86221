"""Decides which set-point a robot may follow now (pure): turns, connection, silence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.driver.checks import TurnFence, unit, within
from wax.driver.interface import STANDSTILL

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist


@dataclass(frozen=True, slots=True)
class Order:
    """The set-point to send; `axes` has the position, -1…1, of each axis set so far."""

    twist: Twist
    turn: int
    axes: tuple[tuple[str, float], ...] = ()


class SetPoints:
    """Keeps the newest set-point, and forgets it when the robot must no longer follow it.

    - A set-point of a lower turn than one seen before is ignored; a stop never is.
    - Without a new set-point for `ttl_s` the robot stops, and motion must wait for a set-point of
      standstill: a process that was frozen that long may be about to send an outdated one.
    - Set-points from before or during a lost connection are forgotten. Once connected, a set-point
      of standstill must come before any motion, so that only a new deliberate command moves.
    """

    def __init__(self, limits: Limits, ttl_s: float) -> None:
        self._limits = limits
        self._ttl_s = ttl_s
        self._fence = TurnFence()
        self._turn = 0
        self._twist = STANDSTILL
        self._axes: dict[str, float] = {}
        self._expires_s = math.inf
        self._connected = False
        self._armed = False

    def connected(self) -> None:
        """Start over: the robot is connected, for the first time or again."""
        self._connected = True
        self._forget()

    def lost(self) -> None:
        """Forget everything: the connection is lost."""
        self._connected = False
        self._forget()

    def apply(self, twist: Twist, turn: int, now_s: float) -> None:
        """Set the motion, clipped to the limits."""
        self._look(now_s)
        if not self._admits(turn) or not self._connected:
            return
        wanted = within(twist, self._limits)
        self._armed = self._armed or wanted.is_zero
        if self._armed:
            self._twist = wanted
            self._expires_s = now_s + self._ttl_s

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Set an axis; one that the robot does not have is ignored."""
        if name in self._limits.axes and self._admits(turn) and self._connected:
            self._axes[name] = unit(position)

    def stop(self, turn: int) -> None:
        """Set standstill, whatever the turn."""
        self._admits(turn)
        self._twist = STANDSTILL
        self._armed = True

    def order(self, now_s: float) -> tuple[Order, float]:
        """Return the present order, and when it changes by itself (infinite if never)."""
        self._look(now_s)
        expires_s = math.inf if self._twist.is_zero else self._expires_s
        return Order(self._twist, self._turn, tuple(self._axes.items())), expires_s

    def _look(self, now_s: float) -> None:
        """Stop, and require standstill first, if the newest set-point of motion is too old."""
        if not self._twist.is_zero and now_s >= self._expires_s:
            self._twist, self._armed = STANDSTILL, False

    def _admits(self, turn: int) -> bool:
        if not self._fence.admits(turn):
            return False
        if turn > self._turn:
            self._twist = STANDSTILL
        self._turn = turn
        return True

    def _forget(self) -> None:
        self._twist = STANDSTILL
        self._axes.clear()
        self._armed = False
