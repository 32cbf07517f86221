"""Every call to the driver goes through here: whatever a driver raises, nothing passes beyond.

A real robot's runs in a process of its own, and what it raises ends in `robot.process.child_loop`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.checks import NO_ANSWER, checked
from wax.driver.hand import HasPassenger
from wax.driver.interface import STANDSTILL, HasControls, HasDeadline, RobotState, Twist
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.control.controls import Working
    from wax.control.gate import Setpoint
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

NOT_CONNECTED: Final = Sentence("robot.not_connected")


class SafeDriver:
    """Calls the driver, and remembers its newest set-point and state.

    `state` is the newest reported; while the driver does not answer, the last one with that
    problem. `problem` is what the newest `check` returned. `twist` is the newest accepted
    set-point. A driver that raises is stopped, counted in `failures`, and logged once until it
    works again.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._passenger = driver if isinstance(driver, HasPassenger) else None
        self._controlled = driver if isinstance(driver, HasControls) else None
        self._timed = driver if isinstance(driver, HasDeadline) else None
        self._axes: dict[str, float] = {}
        self._working: dict[str, Working] = {}
        self._answers = True
        self._lent_for: Sentence | None = None
        self.twist: Twist = STANDSTILL
        self.state = RobotState(connected=False)
        self.epoch: int | None = None
        self.problem: Sentence | None = None
        self.failures = 0

    @property
    def is_moving(self) -> bool:
        """Whether the newest set-point that the driver took asks for motion."""
        return not self.twist.is_zero

    @property
    def is_bumped(self) -> bool:
        """Whether the robot reports a pressed bumper."""
        return self.state.bumpers != 0

    @property
    def axes(self) -> dict[str, float]:
        """Where the axes were sent since the robot connected."""
        return dict(self._axes)

    def lend(self, reason: Sentence | None, turn: int) -> None:
        """Stop the robot and leave the driver to another user while there is a reason.

        Taking it back counts as a new connection: the next `check` stops the robot.
        """
        if reason is not None and self._lent_for is None:
            self.stop(turn)
            self.operate({}, turn)
        if reason is None and self._lent_for is not None:
            self.epoch = None
        self._lent_for = reason

    def check(self, turn: int) -> Sentence | None:
        """Return why the robot cannot be driven; `epoch` changes when it has reconnected."""
        self.problem = self._check(turn)
        return self.problem

    def _check(self, turn: int) -> Sentence | None:
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
            self._axes.clear()  # their positions are unknown now
            self.stop(turn)
            self.operate({}, turn)  # what was set is sent again, and what is still held
        return state.said or (None if state.connected else NOT_CONNECTED)

    def tell_passenger(self, *, is_operated: bool) -> None:
        """Tell a driver with a person aboard whether an operator is there who may drive."""
        if self._passenger is not None:
            self._passenger.tell_passenger(is_operated=is_operated)

    def expect(self, end_s: float) -> None:
        """Tell a driver with a clock of its own when the next set-point's command is too old."""
        if self._timed is not None:
            self._timed.expect(end_s)

    def changes_axes(self, axes: Mapping[str, float]) -> bool:
        """Whether any axis would get a new position."""
        return bool(self._changes(axes))

    def steer(self, setpoint: Setpoint, turn: int) -> Sentence | None:
        """Give the robot its set-point; return a sentence if the driver raised and was stopped.

        Motion that ends with a `reason` ends with `Driver.stop`, not with a set-point of zero.
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

    def changes_controls(self, working: Mapping[str, Working]) -> bool:
        """Whether any control would get a new value."""
        return self._controlled is not None and self._working != working

    def operate(self, working: Mapping[str, Working], turn: int) -> Sentence | None:
        """Tell the robot which controls have changed; return a sentence if the driver raised."""
        if self._lent_for is not None or self._controlled is None:
            return None
        try:
            for name, was in list(self._working.items()):
                if name not in working:
                    self._release(name, was, turn)
            for name, now in working.items():
                if self._working.get(name) != now:
                    self._controlled.control(name, now.value, turn)
                    self._working[name] = now
        except Exception:
            self._failed()
            self.stop(turn)
            return NO_ANSWER
        return None

    def stop(self, turn: int) -> None:
        """Stop the robot now; does nothing while the driver is lent."""
        if self._lent_for is None:
            self.stop_even_if_lent(turn)

    def stop_even_if_lent(self, turn: int) -> None:
        """Stop the robot now, even while the driver is lent."""
        self.twist = STANDSTILL
        try:
            self._driver.stop(turn)
            for name, was in list(self._working.items()):
                if was.moves:
                    self._release(name, was, turn)
        except Exception:
            self._failed()

    def _release(self, name: str, was: Working, turn: int) -> None:
        """Let go of a control that is held; one that was set keeps its value."""
        if was.is_held and self._controlled is not None:
            self._controlled.control(name, was.released, turn)
        self._working.pop(name)

    def _changes(self, axes: Mapping[str, float]) -> dict[str, float]:
        return {name: to for name, to in axes.items() if self._axes.get(name) != to}

    def _failed(self) -> None:
        self.failures += 1
        if self._answers:
            _LOG.exception("the robot's driver raised; the robot is stopped")
        self._answers = False
