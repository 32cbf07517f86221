"""The connection to a ROS 2 robot, as a line: what is checked, sent and heard on it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, ClassVar, Final

import structlog

from wax.driver.checks import NO_ANSWER
from wax.errors import DriverError
from wax.robot.line.kept_line import RobotLine
from wax.robot.ros2 import names
from wax.robot.ros2.command_topic import OURS, SubscribersSeen, judge, other_publishers
from wax.robot.ros2.link import Wanted, command_type
from wax.robot.ros2.open_link import open_link
from wax.robot.ros2.standby_process import StandbyProcess
from wax.robot.ros2.standby_rules import SILENCE_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.robot.ros2.command_topic import Traffic
    from wax.robot.ros2.conversation import Ros2Conversation
    from wax.robot.ros2.link import Link
    from wax.robot.ros2.settings import Ros2Settings
    from wax.sentence import Sentence

_LOG = structlog.get_logger(__name__)

LISTEN_S: Final = 0.05
LOOK_S: Final = 0.1
FAREWELL_S: Final = 0.2
"""How long closing sends standstill if a standby keeps sending it afterwards."""
NEVER_STOPS: Final = (
    "the robot says that it never stops by itself (a time-out of 0): if this machine or the network"
    " fails, it drives on; set its cmd_vel_timeout or velocity_timeout"
)
WRITE_TIMEOUT: Final = (
    "the robot says after how long without a command it stops by itself; write that as"
    " robot.ros2.timeout_s, so that the page shows it and the speed is reckoned from it"
)
ALONE_FAREWELL_S: Final = 0.6
"""How long it does so without a standby: as long as closing may take."""


class Session(RobotLine):
    """The connection, with the standby that sends standstill whenever this process cannot."""

    hears: ClassVar[bool] = True
    _link: Link

    def __init__(self, settings: Ros2Settings, clock: Clock, talk: Ros2Conversation) -> None:
        self._settings = settings
        self._clock = clock
        self._talk = talk
        self._standby: StandbyProcess | None = None
        self._owed = self._is_leaving = False
        self._look_s = 0.0
        self._subscribers = SubscribersSeen()
        self._learned_s: float | None = None

    def start(self) -> None:
        self._standby = (
            StandbyProcess(self._settings, self._clock) if self._settings.standby else None
        )
        self._owed = self._is_leaving = False
        self._learned_s = None

    def open(self, wake: Callable[[], None]) -> None:  # noqa: ARG002 - of the base class
        self._link = open_link(
            self._settings, self._clock, mark=OURS, wanted=wanted(self._settings)
        )

    def begin(self, now_s: float) -> None:
        self._subscribers.forget()
        self._look_s = now_s
        self._talk.opened(now_s)

    def close(self) -> None:
        self._link.close()

    def end(self) -> None:
        if self._standby is not None:
            self._standby.leave()

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:  # noqa: ARG002
        """Return why the connection is lost, and log it."""
        if isinstance(error, DriverError):
            why = error.sentence
        else:
            _LOG.error("the robot's link failed", exc_info=error)
            why = NO_ANSWER
        _LOG.warning("the robot's link is lost", problem=str(why))
        return why

    # --- what is sent ------------------------------------------------------------------------

    def step(self, now_s: float) -> float:
        again_s = self._say(now_s)
        if self._is_leaving:
            return again_s
        if now_s >= self._look_s:
            self._look_s = now_s + LOOK_S
            self._judge()
            return now_s
        return min(again_s, self._look_s)

    def leave(self, now_s: float) -> float:
        """Send standstill as long as closing allows; a standby continues for longer.

        The standby starts once the link is closed, so that its message overtakes no motion.
        """
        self._is_leaving = True
        self._begin_anew(now_s)
        has_standby = self._standby is not None and self._standby.is_ready
        return FAREWELL_S if has_standby else ALONE_FAREWELL_S

    def _say(self, now_s: float) -> float:
        """Send what is due; return the latest time of the next call."""
        if self._standby is not None and now_s >= self._standby.speaks_at_s:
            self._begin_anew(now_s)  # the standby has stopped the robot: old set-points are void
        twist, again_s = self._talk.next(now_s)
        owes = self._talk.owes(now_s)
        if self._standby is not None and (twist is not None or owes != self._owed):
            # Tell the standby first: frozen right after sending motion, we could not.
            self._standby.report(owes=owes)
            self._owed = owes
        if twist is not None:
            if self._clock.now_s() - now_s >= SILENCE_S:  # frozen meanwhile, as above
                self._begin_anew(now_s)
                return now_s
            self._link.send(twist, time.time_ns())
        return again_s

    def _judge(self) -> None:
        """Check whether the robot can be driven, and who else is on the topic."""
        waits = None if self._standby is None else self._standby.poll()
        ours = {self._link.guid} | (set() if self._standby is None else self._standby.guids)
        traffic = self._link.traffic()
        kind = command_type(self._settings)
        promised_s = self._settings.timeout_s
        verdict = judge(traffic, self._settings.topic, kind, ours, promised_s) or waits
        self._learn(traffic)
        if self._subscribers.has_new(traffic, kind) and verdict is None:
            # The base was restarted: the next check connects to it, with a new epoch.
            self._begin_anew(self._clock.now_s())
            return
        self._talk.judged(verdict, alone=not other_publishers(traffic, ours))

    def _learn(self, traffic: Traffic) -> None:
        """Report the robot's own timeout, and what to configure if the host has not."""
        timeout_s = traffic.timeout_s
        # One node's timeout says nothing about the others', but one that never stops decides.
        is_its_own = not timeout_s or len(traffic.subscribers or ()) == 1
        self._talk.promised(timeout_s if is_its_own else None)
        if timeout_s is None or timeout_s == self._learned_s:
            return
        self._learned_s = timeout_s
        if timeout_s <= 0.0:
            _LOG.warning(NEVER_STOPS)
        elif self._settings.timeout_s <= 0.0:
            _LOG.warning(WRITE_TIMEOUT, timeout_s=timeout_s)

    def _begin_anew(self, now_s: float) -> None:
        """Send standstill, and treat the robot as newly connected."""
        self._talk.lost(None)
        self._talk.opened(now_s)

    # --- what is heard -----------------------------------------------------------------------

    def hear(self) -> bool:
        for kind, message in self._link.take(LISTEN_S):
            self._talk.handle_message(kind, message, self._clock.now_s())
        return False


def wanted(settings: Ros2Settings) -> list[Wanted]:
    """Return the configured topics of the robot's telemetry."""
    offers = (
        Wanted("odometry", settings.odometry, names.ODOMETRY),
        Wanted("battery", settings.battery, names.BATTERY),
        Wanted("bumper", settings.bumper, settings.bumper_type),
        Wanted("diagnostics", settings.diagnostics, names.DIAGNOSTICS),
    )
    return [offer for offer in offers if offer.topic]
