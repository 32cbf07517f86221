"""The boundary to the driver: every call goes through here, and no exception leaves it.

A real robot's driver runs in its own process, where `robot.process.child_loop` catches exceptions.
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

    from wax.control.controls import ActiveControl
    from wax.control.gate import Setpoint
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

NOT_CONNECTED: Final = Sentence("robot.not_connected")


class SafeDriver:
    """Calls the driver, and remembers its newest set-point and state.

    `state` is the newest reported; while the driver does not answer, it is the last one with
    `NO_ANSWER` as its problem. `problem` is what the newest `check` returned. `twist` is the newest
    set-point that the driver accepted. A driver that raises is stopped, counted in `failures`, and
    logged once until it works again.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._passenger = driver if isinstance(driver, HasPassenger) else None
        self._controlled = driver if isinstance(driver, HasControls) else None
        self._timed = driver if isinstance(driver, HasDeadline) else None
        self._axes: dict[str, float] = {}
        self._active: dict[str, ActiveControl] = {}
        self._answers = True
        self._lent_for: Sentence | None = None
        self.twist: Twist = STANDSTILL
        self.state = RobotState(connected=False)
        self.epoch: int | None = None
        self.problem: Sentence | None = None
        self.failures = 0

    @property
    def is_moving(self) -> bool:
        """Whether the newest accepted set-point asks for motion."""
        return not self.twist.is_zero

    @property
    def is_bumped(self) -> bool:
        """Whether the robot reports a pressed bumper."""
        return self.state.bumpers != 0

    @property
    def axes(self) -> dict[str, float]:
        """The positions sent to the axes since the robot connected."""
        return dict(self._axes)

    def lend(self, reason: Sentence | None, turn: int) -> None:
        """Stop the robot and lend the driver to another user; with None, take it back.

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
            self.operate({}, turn)  # so that set and still held controls are sent again
        return state.said or (None if state.connected else NOT_CONNECTED)

    def tell_passenger(self, *, is_operated: bool) -> None:
        """Tell a driver with a person aboard whether an operator is present who may drive."""
        if self._passenger is not None:
            self._passenger.tell_passenger(is_operated=is_operated)

    def set_deadline(self, end_s: float) -> None:
        """Tell a driver with a clock of its own when the next set-point's command expires."""
        if self._timed is not None:
            self._timed.set_deadline(end_s)

    def changes_axes(self, axes: Mapping[str, float]) -> bool:
        """Whether any axis would get a new position."""
        return bool(self._changes(axes))

    def steer(self, setpoint: Setpoint, turn: int) -> Sentence | None:
        """Send the robot its set-point; return a sentence if the driver raised and was stopped.

        If the set-point ends motion and has a `reason`, `Driver.stop` is called first.
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

    @property
    def operated(self) -> dict[str, float]:
        """The numbers of the controls that the robot was sent and that are not released."""
        return {name: active.number for name, active in self._active.items()}

    def changes_controls(self, active: Mapping[str, ActiveControl]) -> bool:
        """Whether any control would get a new value."""
        return self._controlled is not None and self._active != active

    def operate(self, active: Mapping[str, ActiveControl], turn: int) -> Sentence | None:
        """Send the robot the changed controls; return a sentence if the driver raised."""
        if self._lent_for is not None or self._controlled is None:
            return None
        try:
            for name, was in list(self._active.items()):
                if name not in active:
                    self._release(name, was, turn)
            for name, now in active.items():
                if self._active.get(name) != now:
                    self._controlled.control(name, now.value, turn)
                    self._active[name] = now
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
            for name, was in list(self._active.items()):
                if was.moves:
                    self._release(name, was, turn)
        except Exception:
            self._failed()

    def _release(self, name: str, was: ActiveControl, turn: int) -> None:
        """Release a held control; one that was set keeps its value."""
        if was.is_held and self._controlled is not None:
            self._controlled.control(name, was.released, turn)
        self._active.pop(name)

    def _changes(self, axes: Mapping[str, float]) -> dict[str, float]:
        return {name: to for name, to in axes.items() if self._axes.get(name) != to}

    def _failed(self) -> None:
        self.failures += 1
        if self._answers:
            _LOG.exception("the robot's driver raised; the robot is stopped")
        self._answers = False
