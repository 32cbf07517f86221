"""What a robot is to WAX.

Every method returns at once (slow input and output belongs in a thread of the driver's own)
and may be called from the event loop. A robot is written as a class with these methods and
named in the configuration as ``package.module:Class``; it is built as
``Class(settings, clock)`` with the `RobotSettings` of the configuration. Building it touches
nothing outside, since it is built once to be asked for `kind` and `limits`, and again in the
process where it is opened (`wax.robot.process`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.settings import VideoSettings


@dataclass(frozen=True, slots=True)
class Twist:
    """A set-point of motion: ahead in m/s (back is negative), turning left in rad/s."""

    linear_mps: float = 0.0
    angular_rps: float = 0.0

    @property
    def is_zero(self) -> bool:
        return self.linear_mps == 0.0 and self.angular_rps == 0.0


STANDSTILL = Twist()


@dataclass(frozen=True, slots=True)
class Limits:
    """What the robot can do at most; `axes` names its auxiliary axes, such as ``pan``.

    `ttl_s` is how long the robot follows a set-point without a new one, before its own watchdog
    stops it; None if that is not known. `silence_s` is how long a driver in a process of its own
    puts up with a silent server before it stops the robot; None where it shares the server's.
    """

    linear_mps: float
    angular_rps: float
    axes: tuple[str, ...] = ()
    ttl_s: float | None = None
    silence_s: float | None = None


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the robot believes it stands: metres, and radians counter-clockwise from x."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True, slots=True)
class RobotState:
    """How the robot is, as far as it tells.

    `problem` is a sentence for a person while the robot cannot be driven, else None.
    `epoch` rises with every (re)connection: a set-point made before is never applied after.
    `moving` is whether a wheel turns by the robot's own account, None where it does not tell.
    `bumpers` has a bit for each pressed bumper. `battery_fraction` is 0 to 1. `extra` is shown on
    the status page and nowhere else.
    """

    connected: bool
    problem: str | None = None
    epoch: int = 0
    moving: bool | None = None
    pose: Pose | None = None
    bumpers: int = 0
    battery_v: float | None = None
    battery_fraction: float | None = None
    extra: dict[str, float] = field(default_factory=dict)


class Driver(Protocol):
    """Moves the robot."""

    @property
    def kind(self) -> str:
        """A short name, such as ``simulated`` or ``serial``."""
        ...

    @property
    def limits(self) -> Limits:
        """Known from the configuration, before `open`."""
        ...

    def open(self) -> None:
        """Start whatever moves the robot; a robot that cannot be reached is retried, not raised."""
        ...

    def apply(self, twist: Twist, turn: int) -> None:
        """Take the newest set-point, within the limits, for the turn with this number.

        A set-point of a lower turn than one seen before is ignored.
        """
        ...

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Move an auxiliary axis to `position` in -1…1."""
        ...

    def stop(self, turn: int) -> None:
        """Stand still now; never refused, whatever the turn."""
        ...

    def close(self) -> None:
        """Stop the robot, then release it; bounded to a second, safe to call twice."""
        ...

    def state(self) -> RobotState:
        """Return the newest known state."""
        ...


@runtime_checkable
class HasCamera(Protocol):
    """A robot that brings its own eye: `[video] source = "robot"`."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source of the wanted size and rate; it may outlive a closed robot."""
        ...


@runtime_checkable
class HasMicrophone(Protocol):
    """A robot that brings its own ear: `[audio] source = "robot"`."""

    def microphone(self, clock: Clock) -> AudioSource:
        """Make a source of what the robot hears; it may outlive a closed robot."""
        ...
