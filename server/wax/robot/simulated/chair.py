"""The simulated robot with a person aboard, whose hand outranks the operator as on a real one.

It runs in the server's process, as its camera does, and applies a driver process's rules there: it
need not outlive the server, since nobody real sits in it.
"""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import TYPE_CHECKING

from wax.driver.checks import unit
from wax.robot.hand.source import LOOK_S, make_hand
from wax.robot.process.driver_watchdog import Apply, DriverWatchdog, SetAxis, SetControl
from wax.robot.process.passenger import PERIOD_S, Passenger, hand_watchdog
from wax.robot.process.pipe_messages import Axis, Control, Halt, Move
from wax.robot.simulated.person import ScriptedPerson
from wax.robot.simulated.robot import SimulatedRobot

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.controls import ControlSettings
    from wax.config.local import LocalSettings
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.driver.hand import HandReading
    from wax.driver.interface import ControlValue, Limits, OwnView, RobotState, Twist
    from wax.robot.process.driver_watchdog import Call
    from wax.speaker.interface import Speaker


class SimulatedChair:
    """A `Driver` with a camera, a microphone, a speaker and a person aboard.

    The person follows `[local] script`, or has a control of their own on a serial line.
    """

    def __init__(
        self,
        settings: RobotSettings,
        local: LocalSettings,
        clock: Clock,
        controls: Iterable[ControlSettings] = (),
    ) -> None:
        self._clock = clock
        self._robot = SimulatedRobot(settings, clock)
        self._limits = replace(self._robot.limits, silence_s=settings.silence_ms / 1000)
        self._person = ScriptedPerson(local, clock.now_s())
        self._watchdog = hand_watchdog(
            local,
            settings,
            DriverWatchdog(self._robot.limits, settings.silence_ms / 1000, controls),
        )
        self._passenger = Passenger(make_hand(local, self, clock), self._watchdog, clock)
        self._lock = threading.Lock()
        self._sequence = 0
        self._is_operated = False
        self._due_s = 0.0
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def kind(self) -> str:
        return self._robot.kind

    @property
    def limits(self) -> Limits:
        return self._limits

    @property
    def own_view(self) -> OwnView:
        return self._robot.own_view

    def open(self) -> None:
        """Start the simulation and the person; no effect if already open."""
        if self._thread is not None:
            return
        self._closing.clear()
        self._robot.open()
        self._passenger.open()
        self._thread = threading.Thread(target=self._live, name="simulated person", daemon=True)
        self._thread.start()

    def hand(self) -> HandReading | None:
        """Return what the scripted person does now (`HasHand`)."""
        return self._person.reading(self._clock.now_s())

    def tell_passenger(self, *, is_operated: bool) -> None:
        with self._lock:
            self._is_operated = is_operated

    def apply(self, twist: Twist, turn: int) -> None:
        with self._lock:
            now_s = self._clock.now_s()
            move = Move(
                sequence=self._next(),
                sent_s=now_s,
                turn=turn,
                linear_mps=twist.linear_mps,
                angular_rps=twist.angular_rps,
                lateral_mps=twist.lateral_mps,
                operated=self._is_operated,
            )
            self._do(self._watchdog.handle(move, now_s))

    def set_axis(self, name: str, position: float, turn: int) -> None:
        if name not in self._limits.axes:
            return
        with self._lock:
            now_s = self._clock.now_s()
            axis = Axis(
                sequence=self._next(), sent_s=now_s, turn=turn, name=name, position=unit(position)
            )
            self._do(self._watchdog.handle(axis, now_s))

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        with self._lock:
            now_s = self._clock.now_s()
            control = Control(
                sequence=self._next(), sent_s=now_s, turn=turn, name=name, value=value
            )
            self._do(self._watchdog.handle(control, now_s))

    def stop(self, turn: int) -> None:
        with self._lock:
            now_s = self._clock.now_s()
            halt = Halt(sequence=self._next(), sent_s=now_s, turn=turn)
            self._do(self._watchdog.handle(halt, now_s))

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        thread.join(timeout=0.5)
        with self._lock:
            self._do(self._watchdog.hold(None, self._clock.now_s()))
        self._passenger.close()
        self._robot.close()

    def state(self) -> RobotState:
        state = self._robot.state()
        with self._lock:
            counts = {name: float(count) for name, count in self._watchdog.counts.items()}
            return replace(
                state,
                problem=state.problem or self._watchdog.problem,
                epoch=state.epoch + self._watchdog.holds,
                aboard=self._watchdog.aboard,
                extra=state.extra | counts,
            )

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a camera that draws the robot's view."""
        return self._robot.camera(settings, clock)

    def microphone(self, clock: Clock) -> AudioSource:
        """Make a microphone that mixes what the robot hears."""
        return self._robot.microphone(clock)

    def speaker(self, clock: Clock) -> Speaker:
        """Return its speaker, which its microphone hears."""
        return self._robot.speaker(clock)

    def _live(self) -> None:
        while not self._closing.wait(LOOK_S):
            with self._lock:
                self._do(self._passenger.read())
                now_s = self._clock.now_s()
                self._do(self._watchdog.tick(now_s))
                if now_s >= self._due_s:
                    self._due_s = now_s + PERIOD_S
                    self._do(self._watchdog.repeat(now_s))

    def _do(self, calls: tuple[Call, ...]) -> None:
        for call in calls:
            match call:
                case Apply():
                    self._robot.apply(call.twist, call.turn)
                case SetAxis():
                    self._robot.set_axis(call.name, call.position, call.turn)
                case SetControl():
                    self._robot.control(call.name, call.value, call.turn)
                case _:
                    self._robot.stop(call.turn)

    def _next(self) -> int:
        self._sequence += 1
        return self._sequence
