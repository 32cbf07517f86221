"""Keeps the connection to a ROS 2 robot: one thread sends, another receives."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.checks import NO_ANSWER
from wax.errors import DriverError
from wax.robot.ros2 import names
from wax.robot.ros2.command_topic import OURS, SubscribersSeen, judge, other_publishers
from wax.robot.ros2.link import Wanted, command_type
from wax.robot.ros2.open_link import open_link
from wax.robot.ros2.standby_process import StandbyProcess
from wax.robot.ros2.standby_rules import SILENCE_S

if TYPE_CHECKING:
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


class Session:
    """From `run` to `close` it keeps the link open, reopening it when it is lost."""

    def __init__(self, settings: Ros2Settings, clock: Clock, talk: Ros2Conversation) -> None:
        self._settings = settings
        self._clock = clock
        self._talk = talk
        self._standby = StandbyProcess(settings, clock) if settings.standby else None
        self._changed = threading.Condition()
        self._news = False
        self._closing = False
        self._owed = False
        self._subscribers = SubscribersSeen()
        self._learned_s: float | None = None
        self._is_open = False
        self._error: DriverError | None = None

    def wake(self) -> None:
        """Send a changed set-point now."""
        with self._changed:
            self._news = True
            self._changed.notify()

    def close(self) -> None:
        """Make `run` stop the robot and return."""
        with self._changed:
            self._closing = True
            self._changed.notify()

    def run(self) -> None:
        """Connect and stay connected until `close`."""
        try:
            while not self._closing:
                try:
                    self._connect()
                except DriverError as error:
                    self._lost(error.sentence)
                except Exception:
                    # If this thread died silently, the robot would count as connected for ever.
                    _LOG.exception("the robot's link failed")
                    self._lost(NO_ANSWER)
                else:
                    continue
                self._rest(self._settings.reopen_s)
        finally:
            if self._standby is not None:
                self._standby.leave()

    def _connect(self) -> None:
        self._error = None
        link = open_link(self._settings, self._clock, mark=OURS, wanted=wanted(self._settings))
        listener = threading.Thread(
            target=self._listen, args=(link,), name="ros2 listener", daemon=True
        )
        self._is_open = True
        try:
            self._subscribers.forget()
            self._talk.opened()
            listener.start()
            self._send(link)
        finally:
            self._is_open = False
            if listener.ident is not None:
                listener.join()
            with contextlib.suppress(DriverError):
                link.close()

    # --- what is sent ------------------------------------------------------------------------

    def _send(self, link: Link) -> None:
        look_s = self._clock.now_s()
        while not self._closing:
            self._news = False
            now_s = self._clock.now_s()
            again_s = self._say(link)
            if now_s >= look_s:
                look_s = now_s + LOOK_S
                self._judge(link)
                continue
            self._pause(min(again_s, look_s) - self._clock.now_s())
            if self._error is not None:
                raise self._error
        self._farewell(link)

    def _say(self, link: Link) -> float:
        """Send what is due; return the latest time of the next call."""
        now_s = self._clock.now_s()
        if self._standby is not None and now_s >= self._standby.speaks_at_s:
            self._begin_anew()  # the standby has stopped the robot, so earlier set-points are void
        twist, again_s = self._talk.next(now_s)
        owes = self._talk.owes(now_s)
        if self._standby is not None and (twist is not None or owes != self._owed):
            # Tell the standby first: frozen right after sending motion, we could not.
            self._standby.report(owes=owes)
            self._owed = owes
        if twist is not None:
            if self._clock.now_s() - now_s >= SILENCE_S:  # frozen meanwhile, as above
                self._begin_anew()
                return now_s
            link.send(twist, time.time_ns())
        return again_s

    def _judge(self, link: Link) -> None:
        """Check whether the robot can be driven, and who else is on the topic."""
        waits = None if self._standby is None else self._standby.poll()
        ours = {link.guid} if self._standby is None else {link.guid, *self._standby.guids}
        traffic = link.traffic()
        kind = command_type(self._settings)
        promised_s = self._settings.timeout_s
        verdict = judge(traffic, self._settings.topic, kind, ours, promised_s) or waits
        self._learn(traffic)
        if self._subscribers.has_new(traffic, kind) and verdict is None:
            # The base was restarted: the next check connects to it, with a new epoch.
            self._begin_anew()
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

    def _farewell(self, link: Link) -> None:
        """Send standstill as long as closing allows; a standby continues for longer.

        The standby starts once the link is closed, so that its message overtakes no motion.
        """
        self._begin_anew()
        has_standby = self._standby is not None and self._standby.is_ready
        end_s = self._clock.now_s() + (FAREWELL_S if has_standby else ALONE_FAREWELL_S)
        while (now_s := self._clock.now_s()) < end_s:
            time.sleep(max(0.0, min(self._say(link), end_s) - now_s))

    def _begin_anew(self) -> None:
        """Send standstill, and treat the robot as newly connected."""
        self._talk.lost(None)
        self._talk.opened()

    def _lost(self, why: Sentence) -> None:
        _LOG.warning("the robot's link is lost", problem=str(why))
        self._talk.lost(why)

    def _pause(self, pause_s: float) -> None:
        with self._changed:
            self._changed.wait_for(self._must_act, min(max(0.0, pause_s), threading.TIMEOUT_MAX))

    def _rest(self, pause_s: float) -> None:
        """Wait, ignoring new set-points: a failed send must not be retried at once."""
        with self._changed:
            self._changed.wait_for(lambda: self._closing, pause_s)

    def _must_act(self) -> bool:
        return self._news or self._closing or self._error is not None

    # --- what is heard -----------------------------------------------------------------------

    def _listen(self, link: Link) -> None:
        try:
            while self._is_open:
                for kind, message in link.take(LISTEN_S):
                    self._talk.handle_message(kind, message, self._clock.now_s())
        except DriverError as error:
            self._give_up(error)
        except Exception:
            _LOG.exception("what the robot tells cannot be heard")
            self._give_up(DriverError(NO_ANSWER))

    def _give_up(self, error: DriverError) -> None:
        """Make the sender reconnect."""
        with self._changed:
            self._error = error
            self._changed.notify()


def wanted(settings: Ros2Settings) -> list[Wanted]:
    """Return the configured topics of the robot's telemetry."""
    offers = (
        Wanted("odometry", settings.odometry, names.ODOMETRY),
        Wanted("battery", settings.battery, names.BATTERY),
        Wanted("bumper", settings.bumper, settings.bumper_type),
        Wanted("diagnostics", settings.diagnostics, names.DIAGNOSTICS),
    )
    return [offer for offer in offers if offer.topic]
