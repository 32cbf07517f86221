"""The last station before the driver: whatever a driver does, nothing raises beyond this."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.checks import NO_ANSWER, checked
from wax.driver.interface import STANDSTILL, RobotState, Twist

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.control.gate import Setpoint
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

NOT_CONNECTED: Final = "The robot is not connected."


class SafeDriver:
    """Tells the driver what to do, and remembers what it was told and what it said of itself.

    `state` is the newest that it said; while it does not answer, the last with that problem.
    `twist` is the newest set-point that it took. A driver that raises is stopped, counted in
    `failures`, and logged once until all is well.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._axes: dict[str, float] = {}
        self._answers = True
        self._lent_for: str | None = None
        self.twist: Twist = STANDSTILL
        self.state = RobotState(connected=False)
        self.epoch: int | None = None
        self.failures = 0

    @property
    def is_moving(self) -> bool:
        """Whether the newest set-point that the driver took asks for motion."""
        return not self.twist.is_zero

    @property
    def is_bumped(self) -> bool:
        """Whether the robot reports a pressed bumper."""
        return self.state.bumpers != 0

    def lend(self, reason: str | None, turn: int) -> None:
        """Leave the driver to somebody else while there is a reason, after a last stop.

        Taking it back counts as a new connection of the robot: it is stopped by the next `check`.
        """
        if reason is not None and self._lent_for is None:
            self.stop(turn)
        if reason is None and self._lent_for is not None:
            self.epoch = None
        self._lent_for = reason

    def check(self, turn: int) -> str | None:
        """Say why the robot cannot be driven; `epoch` changes when it was connected anew."""
        if self._lent_for is not None:
            self.state = replace(self.state, problem=self._lent_for, moving=None)
            return self._lent_for
        try:
            state = checked(self._driver.state())
        except Exception:
            self.state = replace(self.state, problem=NO_ANSWER, moving=None)
            self._failed()
            self.stop(turn)
            return NO_ANSWER
        self.state = state
        if state.epoch != self.epoch:
            self.epoch = state.epoch
            self._axes.clear()  # where they stand is not known any more
            self.stop(turn)
        return state.problem or (None if state.connected else NOT_CONNECTED)

    def would_turn(self, axes: Mapping[str, float]) -> bool:
        """Tell whether some axis would be set to another position than the last."""
        return bool(self._changes(axes))

    def steer(self, setpoint: Setpoint, turn: int) -> str | None:
        """Give the robot its set-point; a sentence if the driver raised, which was stopped then.

        Motion that ends with a `reason` ends with `Driver.stop`, not with a mere set-point.
        """
        if self._lent_for is not None:
            return None
        if setpoint.reason is not None and setpoint.twist.is_zero and self.is_moving:
            self.stop(turn)
        try:
            self._driver.apply(setpoint.twist, turn)
            self.twist = setpoint.twist
            for name, position in self._changes(setpoint.axes).items():
                self._driver.set_axis(name, position, turn)
                self._axes[name] = position
        except Exception:
            self._failed()
            self.stop(turn)
            return NO_ANSWER
        if setpoint.reason != NO_ANSWER:
            self._answers = True
        return None

    def stop(self, turn: int) -> None:
        """Stand still now; not a word while the driver is lent."""
        if self._lent_for is None:
            self.stop_whoever_has_it(turn)

    def stop_whoever_has_it(self, turn: int) -> None:
        """Stand still now, also while the driver is lent."""
        self.twist = STANDSTILL
        try:
            self._driver.stop(turn)
        except Exception:
            self._failed()

    def _changes(self, axes: Mapping[str, float]) -> dict[str, float]:
        return {name: to for name, to in axes.items() if self._axes.get(name) != to}

    def _failed(self) -> None:
        self.failures += 1
        if self._answers:
            _LOG.exception("the robot's driver raised; the robot is stopped")
        self._answers = False
