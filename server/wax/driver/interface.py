"""The interface of a robot driver.

A driver is a class with these methods, named in the configuration as ``package.module:Class``, or
by the name of its package's entry point in the group ``wax.drivers``. It is constructed as
``Class(settings, clock)`` with the configuration's `RobotSettings`. If it has a nested class
`Settings` (`wax.config.driver_settings`), its own configuration table is parsed into that, and
``settings.own(Class.Settings)`` returns it.

Every method may be called from the event loop and must return at once: do slow input and output in
a thread of your own. The constructor must not touch the hardware: the class is constructed once to
read `kind` and `limits`, again in the process that opens it (`wax.robot.process`), and a third
time, never opened, in the process that reads its camera and microphone (`wax.robot.media`), if it
has any. Import optional libraries in the constructor: then the message about a missing one says
how to install it. Where the system allows it, these calls and the threads that `open` starts run
with real-time priority: none may spin. Start a process in `wax.machine.priority.as_others`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping  # noqa: TC003  # pydantic looks it up where a state is sent
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol, runtime_checkable

from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.video import VideoSettings
    from wax.speaker.interface import Speaker


@dataclass(frozen=True, slots=True)
class Twist:
    """A set-point of motion in the plane, by the axes of REP 103.

    Ahead in m/s (back is negative), turning left in rad/s (right is negative), and sideways to the
    left in m/s (to the right is negative), which is 0 where `Limits.lateral_mps` is.
    """

    linear_mps: float = 0.0
    angular_rps: float = 0.0
    lateral_mps: float = 0.0

    @property
    def is_zero(self) -> bool:
        return self.linear_mps == 0.0 and self.angular_rps == 0.0 and self.lateral_mps == 0.0

    @property
    def speed_mps(self) -> float:
        """How fast its middle moves, whatever the direction."""
        return math.hypot(self.linear_mps, self.lateral_mps)

    def scaled(self, factor: float) -> Twist:
        """Return the same motion `factor` times as fast: a curve keeps its radius."""
        return Twist(self.linear_mps * factor, self.angular_rps * factor, self.lateral_mps * factor)


STANDSTILL = Twist()


@dataclass(frozen=True, slots=True)
class Limits:
    """The robot's limits; `axes` names its auxiliary axes, such as ``pan``.

    `lateral_mps` is how fast it moves sideways, 0 for a robot that cannot. The speed of its middle
    is limited as a whole: sideways and ahead at once is no faster than either (`checks.within`).
    A robot that could go faster than `[robot]` allows is not asked to, in any direction.
    `controls` names its other controls, for `[[controls]]`; the driver is then a `HasControls`.
    `ttl_s` is how long the robot follows a set-point before its own watchdog stops it; None if
    unknown. `silence_s` is how long the driver process tolerates a silent server before it stops
    the robot; None for the simulated robot, which runs inside the server's process.
    """

    linear_mps: float
    angular_rps: float
    axes: tuple[str, ...] = ()
    ttl_s: float | None = None
    silence_s: float | None = None
    controls: tuple[str, ...] = ()
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class Pose:
    """The robot's own estimate of its position in metres, heading in radians from x to the left."""

    x_m: float
    y_m: float
    heading_rad: float


HandMode = Literal["free", "hand", "pause", "stopped", "lost"]
"""Who may drive, according to the hand control of the person aboard (`wax.control.local_hand`)."""

Ask = Literal["wait", "go_on", "left", "right"]
"""What the person aboard asks the operator for."""


@dataclass(frozen=True, slots=True)
class Aboard:
    """The state of the hand control of the person aboard.

    Only in the mode ``free`` may an operator drive, with the `share` (0 to 1) of their set-point
    that the person lets through. `asked` is the newest request and `asks` its rising number, 0
    before the first.
    """

    mode: HandMode
    share: float = 1.0
    asked: Ask | None = None
    asks: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What a robot tells of itself, as far as it tells anything."""

    moving: bool | None = None
    """Whether the robot reports that a wheel turns, None if it does not report that."""
    pose: Pose | None = None
    bumpers: int = 0
    """A bit for each pressed bumper, only shown to people; the robot itself refuses to drive on."""
    battery_v: float | None = None
    battery_fraction: float | None = None
    """0 (empty) to 1 (full)."""
    gauges: Mapping[str, float] = field(default_factory=dict)
    """Numbers by the gauge names that `[[gauges]]` may use."""
    ttl_s: float | None = None
    """The timeout without set-points after which the robot says that it stops, 0 if it never does;
    None if it does not say: then the one in `Limits` counts."""
    extra: dict[str, float] = field(default_factory=dict)
    """Shown only on the status page."""

    @property
    def told(self) -> dict[str, float | None]:
        """The values of `wax.protocol.robot_report` by name; most are among the gauges."""
        return {
            **self.gauges,
            "bumpers": self.bumpers,
            "battery_v": self.battery_v,
            "battery_fraction": self.battery_fraction,
        }


@dataclass(frozen=True, slots=True)
class RobotState(Reading):
    """What a robot tells, and whether it is connected."""

    connected: bool
    problem: Sentence | str | None = None
    """Why the robot cannot be driven, else None. Text is shown as it is; a `Sentence`, one of WAX's
    own, is shown in the language of each page."""
    epoch: int = 0
    """Rises with every (re)connection: a set-point is never applied in a later epoch."""
    aboard: Aboard | None = field(default=None, kw_only=True)
    """None for a robot without a hand control aboard."""

    @property
    def said(self) -> Sentence | None:
        """The problem as a `Sentence` for the page."""
        if self.problem is None or isinstance(self.problem, Sentence):
            return self.problem
        return says(self.problem) if self.problem else None


@dataclass(frozen=True, slots=True)
class OwnView:
    """How a robot's own camera sees the floor, and how wide the robot is.

    The camera is above the middle of the robot, `height_m` above the floor, tilted down by
    `tilt_deg`, with a horizontal field of view of `fov_deg`. `axis_row` is the row of the optical
    axis, as a share of the picture's height: 0.5 with every real lens.
    """

    height_m: float
    tilt_deg: float
    fov_deg: float
    width_m: float
    axis_row: float = 0.5


class Driver(Protocol):
    """Moves the robot."""

    @property
    def kind(self) -> str:
        """A short name, such as ``simulated`` or ``serial``."""
        ...

    @property
    def limits(self) -> Limits:
        """The limits, known from the configuration before `open`."""
        ...

    def open(self) -> None:
        """Start the driver; retry an unreachable robot instead of raising."""
        ...

    def apply(self, twist: Twist, turn: int) -> None:
        """Follow the newest set-point, within the limits, for the turn with this number.

        A set-point with a lower turn than any earlier call's is ignored.
        """
        ...

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Move an auxiliary axis to `position` in -1…1."""
        ...

    def stop(self, turn: int) -> None:
        """Stop now; never refused, whatever the turn."""
        ...

    def close(self) -> None:
        """Stop the robot, then release it; takes at most a second, safe to call twice."""
        ...

    def state(self) -> RobotState:
        """Return the newest known state."""
        ...


ControlValue = bool | float | str | None
"""A button's or toggle's state, a slider's value, or the text of a choice.

None means that a moving slider was released: what it moves stays where it is."""


@runtime_checkable
class HasControls(Protocol):
    """A robot with lights, a horn or a gripper: `[[controls]]`, by the names in `Limits.controls`.

    `Driver.stop` also stops everything that a control has set in motion.
    """

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        """Set a control's value; a call with a lower turn than any earlier call's is ignored.

        It is called once when the value changes, and again when the robot has reconnected.
        """
        ...


@runtime_checkable
class HasDeadline(Protocol):
    """A driver that ends motion by itself when the operator's command expires."""

    def set_deadline(self, end_s: float) -> None:
        """Learn, before each set-point, the monotonic time at which its command expires.

        The time is infinite if no command moves the robot.
        """
        ...


@runtime_checkable
class HasCamera(Protocol):
    """A robot with its own camera: `[video] source = "robot"`."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source with the size and rate of `settings`.

        It must not depend on `open`, nor on anything that the driver learns there: the two run in
        different processes. The same holds for microphone and speaker.
        """
        ...


@runtime_checkable
class KnowsItsView(Protocol):
    """A robot that knows the geometry of its own camera."""

    @property
    def own_view(self) -> OwnView:
        """How `HasCamera.camera` sees the floor with all axes in the middle."""
        ...


@runtime_checkable
class HasExternalView(Protocol):
    """A robot with a camera that views it from outside: `[[camera]] source = "robot"`."""

    def external_view(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source as `HasCamera.camera` does."""
        ...


@runtime_checkable
class HasMicrophone(Protocol):
    """A robot with its own microphone: `[audio] source = "robot"`."""

    def microphone(self, clock: Clock) -> AudioSource:
        """Make a source of the robot's sound."""
        ...


@runtime_checkable
class HasSpeaker(Protocol):
    """A robot with its own speaker: `[voice] speaker = "robot"`."""

    def speaker(self, clock: Clock) -> Speaker:
        """Make an output for voices."""
        ...
