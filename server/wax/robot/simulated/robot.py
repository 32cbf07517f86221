"""The simulated robot's driver: whoever looks at the simulation steps it up to now."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from wax.driver.interface import OwnView, RobotState
from wax.robot.simulated.camera import SimulatedCamera
from wax.robot.simulated.external_view import ExternalView
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.microphone import SimulatedMicrophone
from wax.robot.simulated.motion import RADIUS_M
from wax.robot.simulated.render import Renderer
from wax.robot.simulated.simulation import Simulation
from wax.robot.simulated.speaker import SimulatedSpeaker
from wax.robot.simulated.view import EYE_HEIGHT_M, FIELD_OF_VIEW_RAD, HORIZON

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.driver.interface import ControlValue, Limits, Twist
    from wax.robot.simulated.simulation import Senses
    from wax.speaker.interface import Speaker


class SimulatedRobot:
    """A `Driver` with a camera, a microphone and a speaker.

    Unlike other drivers it runs in the server's process: its camera draws the position that its
    motion has reached, and a second instance in another process would draw a robot that stands.

    It has its own watchdog and stops when set-points cease. Camera, microphone and speaker also
    work before `open` and after `close`; the robot just does not move then.
    """

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self._clock = clock
        self._world = furnished_flat()
        self._simulation = Simulation(settings, self._world)
        self._speaker = SimulatedSpeaker()
        self._limits = self._simulation.limits
        self._lock = threading.Lock()
        self._is_open = False
        self._epoch = 0

    @property
    def kind(self) -> str:
        return "simulated"

    @property
    def limits(self) -> Limits:
        return self._limits

    @property
    def own_view(self) -> OwnView:
        return OwnView(
            height_m=EYE_HEIGHT_M,
            tilt_deg=0.0,
            fov_deg=math.degrees(FIELD_OF_VIEW_RAD),
            width_m=2.0 * RADIUS_M,
            axis_row=HORIZON,
        )

    def open(self) -> None:
        """Start the simulation; no effect if already open."""
        with self._lock:
            if not self._is_open:
                self._simulation.start(self._clock.now_s())
                self._epoch += 1
            self._is_open = True

    def apply(self, twist: Twist, turn: int) -> None:
        """Follow the newest set-point for 300 ms; before `open` this has no effect."""
        with self._lock:
            now_s = self._clock.now_s()
            if self._is_open:
                self._simulation.advance(now_s)
            self._simulation.apply(twist, turn, now_s)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        with self._lock:
            self._simulation.set_axis(name, position, turn)

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        with self._lock:
            self._simulation.control(name, value, turn)

    def stop(self, turn: int) -> None:
        with self._lock:
            if self._is_open:
                self._simulation.advance(self._clock.now_s())
            self._simulation.stop(turn)

    def close(self) -> None:
        with self._lock:
            if self._is_open:
                self._simulation.start(self._clock.now_s())
            self._is_open = False

    def state(self) -> RobotState:
        senses = self.senses()
        sideways = {"lateral_mps": senses.twist.lateral_mps} if self._limits.lateral_mps > 0 else {}
        return RobotState(
            connected=self._is_open,
            epoch=self._epoch,
            pose=senses.pose,
            gauges={"motor_c": senses.motor_c},
            extra={
                "speed_mps": senses.twist.linear_mps,
                **sideways,
                "pan_rad": senses.pan_rad,
                "bumps": float(senses.bumps),
                "lamp": float(senses.lamp.is_on),
                "horn": float(senses.is_honking),
            },
        )

    def senses(self) -> Senses:
        """Return the current sensor values."""
        with self._lock:
            now_s = self._clock.now_s()
            if self._is_open:
                return self._simulation.advance(now_s)
            return replace(self._simulation.senses, at_s=now_s)

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a camera that draws the robot's view, lit by its lamp."""
        artist = partial(Renderer, self._world)
        return SimulatedCamera(settings, clock, artist=artist, look=self.senses, is_lit=True)

    def external_view(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a camera above the flat (thesis, Fig. 5.55: the external view)."""
        artist = partial(ExternalView, self._world)
        return SimulatedCamera(settings, clock, artist=artist, look=self.senses)

    def microphone(self, clock: Clock) -> AudioSource:
        """Make a microphone that mixes what the robot hears."""
        return SimulatedMicrophone(
            clock, world=self._world, listen=self.senses, speaker=self._speaker
        )

    def speaker(self, clock: Clock) -> Speaker:
        """Return its speaker, which its microphone hears."""
        del clock  # it plays as fast as the microphone reads
        return self._speaker
