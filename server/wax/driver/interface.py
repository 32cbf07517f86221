"""The interface of a robot driver.

A robot is a class with these methods, named in the configuration as ``package.module:Class``, or by
the name of its package's entry point in the group ``wax.drivers``. It is built as ``Class(settings,
clock)`` with the configuration's `RobotSettings`. A table of its own is a class `Settings` in it
(`wax.config.driver_settings`), which ``settings.own(Class.Settings)`` returns, checked.

Every method may be called from the event loop and must return at once: do slow input and output in
a thread of your own. The constructor must not touch the hardware: the class is built once to read
`kind` and `limits`, again in the process that opens it (`wax.robot.process`), and a third time,
never opened, in the process that reads from its camera and microphone (`wax.robot.media`), if it
has any. Import in the constructor what not everybody has installed: then a missing library is told
with the line that installs it. Where it is allowed, these calls and the threads that `open`
starts run in real time: none may spin. Start a process in `wax.machine.priority.as_others`.
"""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003  # pydantic looks it up where a state is sent
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol, runtime_checkable

from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.settings import VideoSettings
    from wax.speaker.interface import Speaker


@dataclass(frozen=True, slots=True)
class Twist:
    """A set-point of motion: forward in m/s (backward is negative), turning left in rad/s."""

    linear_mps: float = 0.0
    angular_rps: float = 0.0

    @property
    def is_zero(self) -> bool:
        return self.linear_mps == 0.0 and self.angular_rps == 0.0


STANDSTILL = Twist()


@dataclass(frozen=True, slots=True)
class Limits:
    """The robot's limits; `axes` names its auxiliary axes, such as ``pan``.

    `controls` names what else it has, as `[[controls]]` may: it is then a `HasControls`.
    `ttl_s` is how long the robot follows a set-point before its own watchdog stops it; None if
    unknown. `silence_s` is how long a driver process waits for a silent server before it stops the
    robot; None for the simulated robot, which is inside the server's.
    """

    linear_mps: float
    angular_rps: float
    axes: tuple[str, ...] = ()
    ttl_s: float | None = None
    silence_s: float | None = None
    controls: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Pose:
    """The robot's own estimate of its position in metres, heading in radians from x to the left."""

    x_m: float
    y_m: float
    heading_rad: float


HandMode = Literal["free", "hand", "pause", "stopped", "lost"]
"""Who has the robot, by the hand control of the person aboard (`wax.control.local_hand`)."""

Ask = Literal["wait", "go_on", "left", "right"]
"""What the person aboard asks the operator for."""


@dataclass(frozen=True, slots=True)
class Aboard:
    """The person aboard, as their hand control tells.

    Only in the mode ``free`` may an operator drive, with the `share` (0 to 1) of their set-point
    that the person lets pass. `asked` is the newest request and `asks` its rising number, 0 before
    the first.
    """

    mode: HandMode
    share: float = 1.0
    asked: Ask | None = None
    asks: int = 0


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot's state, as far as it reports one."""

    connected: bool
    problem: Sentence | str | None = None
    """A sentence for people while the robot cannot be driven, else None. Text is shown as it is; a
    `Sentence` is one of WAX's own, which each page says in its language."""
    epoch: int = 0
    """Rises with every (re)connection: a set-point from before is never applied after."""
    moving: bool | None = None
    """Whether the robot reports that a wheel turns, None if it does not report."""
    pose: Pose | None = None
    bumpers: int = 0
    """A bit for each pressed bumper: shown to people; it is the robot that refuses to go on."""
    battery_v: float | None = None
    battery_fraction: float | None = None
    """0 to 1."""
    aboard: Aboard | None = None
    """None for a robot without a hand control aboard."""
    gauges: Mapping[str, float] = field(default_factory=dict)
    """Numbers by the names that `[[gauges]]` may have."""
    ttl_s: float | None = None
    """After how long without a set-point the robot itself has told that it stops, 0 if it never
    does, None where it does not tell: then that in `Limits` counts."""
    extra: dict[str, float] = field(default_factory=dict)
    """Shown only on the status page."""

    @property
    def said(self) -> Sentence | None:
        """The problem as a page is told it."""
        if self.problem is None or isinstance(self.problem, Sentence):
            return self.problem
        return says(self.problem) if self.problem else None


@dataclass(frozen=True, slots=True)
class OwnView:
    """How a robot's own camera looks at the floor, and how wide the robot is.

    The camera stands above the middle of the robot, `height_m` above the floor, looks down by
    `tilt_deg` and sees `fov_deg` from left to right. `axis_row` is where it looks, as a share of
    the picture's height: the middle with every real lens.
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
        """Take the newest set-point, within the limits, for the turn with this number.

        A set-point of a lower turn than one seen before is ignored.
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
"""Of a button or a toggle whether it is on, of a slider its value, of a choice the words chosen.

None is a moving slider that was let go: what it moves stays where it is."""


@runtime_checkable
class HasControls(Protocol):
    """A robot with lights, a horn or a gripper: `[[controls]]`, by the names in `Limits.controls`.

    `Driver.stop` also ends whatever a control has set in motion.
    """

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        """Take a control's new value; one of a lower turn than one seen before is ignored.

        A value is sent once, when it changes, and again when the robot has reconnected.
        """
        ...


@runtime_checkable
class HasDeadline(Protocol):
    """A driver that ends motion by itself when the operator's command has become too old."""

    def expect(self, end_s: float) -> None:
        """Take, before each set-point, the monotonic time at which its command is too old.

        It is infinite where no command moves the robot.
        """
        ...


@runtime_checkable
class HasCamera(Protocol):
    """A robot with its own camera: `[video] source = "robot"`."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source with the size and rate of `settings`.

        It must not depend on `open`, nor on anything that the driver learns in it: the two are in
        two processes. The same holds for the other senses.
        """
        ...


@runtime_checkable
class KnowsItsView(Protocol):
    """A robot with its own camera that knows how it looks at the floor."""

    @property
    def own_view(self) -> OwnView:
        """How `HasCamera.camera` sees the floor while no axis turns it."""
        ...


@runtime_checkable
class HasExternalView(Protocol):
    """A robot with a camera that looks at it from outside: `[[camera]] source = "robot"`."""

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
