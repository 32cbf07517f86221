"""The driver for a robot that speaks ROS 2."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

import structlog

from wax.driver.interface import Limits
from wax.robot.line.robot import LineRobot
from wax.robot.ros2.conversation import Ros2Conversation
from wax.robot.ros2.open_link import load
from wax.robot.ros2.session import Session
from wax.robot.ros2.settings import Ros2Settings

if TYPE_CHECKING:
    from wax.capture.source import VideoSource
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings

_LOG = structlog.get_logger(__name__)

CLOSE_TIMEOUT_S: Final = 0.95
NO_TIMEOUT: Final = (
    "no time-out of the robot's own is known (robot.ros2.timeout_s): if this machine or the network"
    " fails, a robot without one drives on; diff_drive_controller has cmd_vel_timeout, nav2's"
    " velocity_smoother velocity_timeout, turtlebot3's node none"
)


class Ros2Robot(LineRobot):
    """A `Driver` that publishes Twist or TwistStamped, by DDS or rosbridge.

    It is connected while the command topic has a subscriber and no other publisher. After
    connecting, nothing moves until a set-point of standstill. After `close` has returned, the
    standby keeps sending standstill.
    """

    Settings: ClassVar = Ros2Settings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        own = self._settings = settings.own(Ros2Settings)
        load(own)
        limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            ttl_s=own.timeout_s or None,
            lateral_mps=settings.lateral_mps,
        )
        core = Ros2Conversation(own, limits)
        self._session = Session(own, clock, core)
        super().__init__(
            "ros2",
            limits,
            clock,
            core,
            self._session,
            reopen_s=own.reopen_s,
            close_s=CLOSE_TIMEOUT_S,
        )

    def open(self) -> None:
        if self._limits.ttl_s is None and not self._kept.is_open:
            _LOG.warning(NO_TIMEOUT)
        super().open()

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        """Make a source of the configured topic; the driver need not be open."""
        from wax.robot.ros2.camera import Ros2Camera  # noqa: PLC0415 - it loads OpenCV

        return Ros2Camera(self._settings, settings, clock)
