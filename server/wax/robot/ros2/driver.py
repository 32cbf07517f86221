"""The driver for a robot that speaks ROS 2."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, ClassVar, Final

import structlog

from wax.driver.interface import Limits
from wax.robot.ros2.conversation import Ros2Conversation
from wax.robot.ros2.open_link import load
from wax.robot.ros2.session import Session
from wax.robot.ros2.settings import Ros2Settings

if TYPE_CHECKING:
    from wax.capture.source import VideoSource
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.driver.interface import RobotState, Twist

_LOG = structlog.get_logger(__name__)

CLOSE_TIMEOUT_S: Final = 0.95
NO_TIMEOUT: Final = (
    "no time-out of the robot's own is known (robot.ros2.timeout_s): if this machine or the network"
    " fails, a robot without one drives on; diff_drive_controller has cmd_vel_timeout, nav2's"
    " velocity_smoother velocity_timeout, turtlebot3's node none"
)


class Ros2Robot:
    """A `Driver` that publishes Twist or TwistStamped, by DDS or rosbridge.

    It is connected while the command topic has a subscriber and no other publisher. After
    connecting, nothing moves until a set-point of standstill.
    """

    Settings: ClassVar = Ros2Settings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self._settings = settings.own(Ros2Settings)
        load(self._settings)
        self._clock = clock
        self._limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            ttl_s=self._settings.timeout_s or None,
        )
        self._conversation = Ros2Conversation(self._settings, self._limits)
        self._session = Session(self._settings, clock, self._conversation)
        self._thread: threading.Thread | None = None

    @property
    def kind(self) -> str:
        return "ros2"

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start connecting, and keep trying; no effect if already open."""
        if self._thread is not None:
            return
        if self._limits.ttl_s is None:
            _LOG.warning(NO_TIMEOUT)
        self._session = Session(self._settings, self._clock, self._conversation)
        self._thread = threading.Thread(target=self._session.run, name="ros2", daemon=True)
        self._thread.start()

    def apply(self, twist: Twist, turn: int) -> None:
        self._conversation.apply(twist, turn, self._clock.now_s())
        self._session.wake()

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Do nothing: it has no axes."""

    def stop(self, turn: int) -> None:
        self._conversation.stop(turn, self._clock.now_s())
        self._session.wake()

    def close(self) -> None:
        """Stop the robot; the standby keeps sending standstill after this has returned."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._session.close()
            thread.join(CLOSE_TIMEOUT_S)
        self._conversation.lost(None)

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source of the configured topic; the driver need not be open."""
        from wax.robot.ros2.camera import Ros2Camera  # noqa: PLC0415 - it loads OpenCV

        return Ros2Camera(self._settings, settings, clock)

    def state(self) -> RobotState:
        return self._conversation.state(self._clock.now_s())
