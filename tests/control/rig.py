"""A control loop on a fake clock, with a driver that records its calls."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tests.control.rules import VOUCHED
from tests.idle_robot import IdleRobot
from tests.turned_clock import Turnable, TurnedClock

from wax.clock import Clock, SystemClock
from wax.config.drive import DriveSettings
from wax.config.robot import RobotSettings
from wax.config.settings import Settings
from wax.config.turns import TurnSettings
from wax.control.command import Command
from wax.control.driving_view import DrivingView
from wax.control.listener import Listener
from wax.control.loop import ControlLoop
from wax.control.turns import TurnEvent, Turns
from wax.driver.interface import Driver, Limits, RobotState, Twist

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.controls import ControlSettings, GaugeSettings
    from wax.control.gate import Setpoint
    from wax.control.operators import Operators
    from wax.control.reasons import Refusal
    from wax.driver.interface import ControlValue
    from wax.sentence import Sentence

A, B = 1, 2
AHEAD = Twist(0.5, 0.0)
AGILE = RobotSettings(max_linear_acceleration_mps2=100.0, braking_mps2=100.0)
"""A robot that reaches any speed within one tick."""


class FakeDriver(IdleRobot):
    """Records every call; raises from the methods named in `broken`."""

    kind = "fake"
    limits = Limits(linear_mps=0.5, angular_rps=1.0, axes=("pan",))

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []
        self.applied_s: list[float] = []
        self.now = RobotState(connected=True, epoch=1)
        self.broken: set[str] = set()
        self.called = asyncio.Event()

    def _note(self, name: str, *arguments: object) -> None:
        self.calls.append((name, *arguments))
        if name == "apply":
            self.applied_s.append(SystemClock().now_s())
        self.called.set()
        if name in self.broken:
            raise OSError(f"{name} failed")

    def open(self) -> None:
        self._note("open")

    def apply(self, twist: Twist, turn: int) -> None:
        self._note("apply", twist, turn)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._note("set_axis", name, position, turn)

    def stop(self, turn: int) -> None:
        self._note("stop", turn)

    def close(self) -> None:
        self._note("close")

    def state(self) -> RobotState:
        if "state" in self.broken:
            raise OSError("state failed")
        return self.now

    def take(self) -> list[tuple[object, ...]]:
        """Return the calls since the last time."""
        calls, self.calls = self.calls, []
        return calls


class EquippedDriver(FakeDriver):
    """A driver that can be sent the numbers of controls."""

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        self._note("control", name, value, turn)


class FakeOperators:
    """People 100 ms away who see the picture, in a room whose host limits nothing."""

    def __init__(self, delay_s: float = 0.1) -> None:
        self.delays_s = {A: delay_s, B: delay_s}
        self.has_picture = True
        self.asked_what_they_see: set[int] = set()
        self.fraction = 1.0
        self.on_hold: Sentence | None = None

    def link_delay_s(self, number: int) -> float | None:
        return self.delays_s.get(number)

    def sees(self, number: int) -> bool:
        self.asked_what_they_see.add(number)
        return self.has_picture

    def max_fraction(self, number: int) -> float:
        return self.fraction


_DEFAULTS = Settings(robot=AGILE)


def make_loop(
    clock: Clock,
    driver: Driver,
    *listeners: Listener,
    turns: Turns | None = None,
    operators: Operators | None = None,
    view: DrivingView | None = None,
    **tables: Any,
) -> ControlLoop:
    """Make a loop of a robot with an ideal camera; `tables` replace some of the settings'."""
    if view is None:
        view = DrivingView()
        view.clock = VOUCHED
    loop = ControlLoop(
        clock=clock,
        settings=_DEFAULTS.model_copy(update=tables),
        driver=driver,
        turns=turns or Turns(TurnSettings()),
        operators=operators or FakeOperators(),
        view=view,
    )
    loop.listen(*listeners)
    return loop


class Bench(Listener):
    """A control loop with everything around it."""

    def __init__(
        self,
        *,
        turn_s: float = 60.0,
        grace_s: float = 3.0,
        ready_s: float = 0.0,
        limits: Limits = FakeDriver.limits,
        robot: RobotSettings = AGILE,
        max_stop_distance_m: float = 1.0,
        clock: Turnable | None = None,
        driver: FakeDriver | None = None,
        controls: Sequence[ControlSettings] = (),
        gauges: Sequence[GaugeSettings] = (),
    ) -> None:
        self.clock: Turnable = clock or TurnedClock()
        self.driver = driver or FakeDriver()
        self.driver.limits = limits
        self.turns = Turns(TurnSettings(turn_s=turn_s, grace_s=grace_s, ready_s=ready_s))
        self.operators = FakeOperators()
        self.view = DrivingView()
        self.view.clock = VOUCHED
        self.events: list[TurnEvent] = []
        self.calls_before_event: list[tuple[object, ...]] = []
        self.statuses: list[tuple[int, bool, Sentence | None]] = []
        self.shares: list[float] = []
        self.listened: list[tuple[object, ...]] = []
        self.calls_before_steered: list[tuple[object, ...]] = []
        self.seq = 0
        self.loop = make_loop(
            self.clock,
            self.driver,
            self,
            turns=self.turns,
            operators=self.operators,
            view=self.view,
            drive=DriveSettings(
                loop_hz=50.0,
                max_age_ms=150.0,
                slow_fraction=0.5,
                max_stop_distance_m=max_stop_distance_m,
            ),
            robot=robot,
            controls=controls,
            gauges=gauges,
        )

    def command_handled(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None:
        self.listened.append(("offered", viewer, command.seq, refusal))

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        self.listened.append(("steered", wanted.twist, sent, turn))
        self.calls_before_steered = list(self.driver.calls)

    def drive_status(
        self, number: int, moving: bool, reason: Sentence | None, share: float
    ) -> None:
        self.statuses.append((number, moving, reason))
        self.shares.append(share)

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        self.events += events
        self.calls_before_event = list(self.driver.calls)

    def step(self, after_s: float = 0.02) -> list[tuple[object, ...]]:
        """Run one step after this time; return the driver's calls in it."""
        self.driver.take()
        self.clock.time_s += after_s
        self.loop.step(self.clock.time_s)
        return self.driver.take()

    def command(self, linear: float = 0.0) -> Command:
        self.seq += 1
        return Command(
            seq=self.seq,
            turn=self.turns.number,
            sent_s=self.clock.time_s,
            linear=linear,
            angular=0.0,
            held=linear != 0,
            speed="fast",
            seen_s=self.clock.time_s,
            heard_s=self.clock.time_s,
        )

    def offer(self, linear: float = 0.0, *, viewer: int = A) -> Refusal | None:
        return self.loop.handle_command(viewer, self.command(linear))

    def pan(self, position: float, *, held: bool = True) -> Refusal | None:
        """Offer a command that names an axis, and asks for no other motion."""
        command = replace(self.command(), held=held, axes={"pan": position})
        return self.loop.handle_command(A, command)

    def enter(self, *viewers: int) -> None:
        for viewer in viewers:
            self.loop.connect(viewer)
            self.loop.join(viewer)

    def drive(self, *, viewer: int = A) -> None:
        """Let the operator release everything, then drive ahead, and check that the robot moves."""
        assert self.offer(viewer=viewer) is None
        self.step()
        assert self.offer(1.0, viewer=viewer) is None
        assert ("apply", AHEAD, self.turns.number) in self.step()

    def moves(self) -> bool:
        """Whether the robot moves after a fresh attempt to drive without letting go first."""
        self.step()
        self.offer(1.0, viewer=self.turns.operator or A)
        return ("apply", AHEAD, self.turns.number) in self.step()
