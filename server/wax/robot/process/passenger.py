"""The person aboard in the driver process: their control, its rules, and who may have the robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax.control.local_hand import HandRules
from wax.robot.hand.source import make_hand
from wax.robot.process.hand_watchdog import HandWatchdog
from wax.robot.process.passenger_claim import Claim
from wax.robot.process.stop_mark import StopMark

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.local import LocalSettings
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Driver
    from wax.robot.hand.source import HandSource
    from wax.robot.process.driver_watchdog import Call, DriverWatchdog
    from wax.robot.process.pipe_messages import Begin

PERIOD_S: Final = 0.02
"""The longest interval between repeats of the person's own set-point."""


class Passenger:
    """Reads the control and passes the readings to `watchdog`.

    Without a `claim` the process ends with its server; without a `stop_mark` the person's Stop is
    lost when the process ends.
    """

    def __init__(
        self,
        hand: HandSource,
        watchdog: HandWatchdog,
        clock: Clock,
        claim: Claim | None = None,
        stop_mark: StopMark | None = None,
    ) -> None:
        self._hand = hand
        self._clock = clock
        self._claim = claim
        self._stop_mark = stop_mark
        self.watchdog = watchdog

    @property
    def wakes(self) -> int | None:
        """See `HandSource.wakes`."""
        return self._hand.wakes

    def claim(self) -> None:
        """Ask the process that still has the robot, if any, to release it."""
        if self._claim is not None:
            self._claim.take()

    def has_robot(self) -> bool:
        """Whether no other process has the robot any more."""
        return self._claim is None or self._claim.has_robot()

    def open(self) -> None:
        """Start reading, with the Stop in force if it was when an earlier process ended."""
        if self._stop_mark is not None and self._stop_mark.is_set:
            self.watchdog.recall_stop()
        self._hand.open()

    def read(self) -> tuple[Call, ...]:
        """Return the calls that follow from the control's new readings."""
        readings = self._hand.take()
        now_s = self._clock.now_s()  # only now: a reading from the future is ignored
        if readings is None:
            return self.watchdog.lose_hand(now_s)
        return self.watchdog.handle_readings(readings, now_s)

    def remember(self) -> None:
        """Save for the next process whether the person's Stop is in force."""
        if self._stop_mark is not None:
            self._stop_mark.keep(self.watchdog.is_stopped)

    def drives_on(self) -> bool:
        """Whether this process outlives its server.

        It does until another process has claimed the robot and no hand is on the control.
        """
        if self._claim is None or not self._claim.is_taken:
            return False
        return self.watchdog.is_in_use or self._claim.is_held

    def close(self) -> None:
        self._hand.close()


def make_passenger(
    begin: Begin, driver: Driver, watchdog: DriverWatchdog, clock: Clock
) -> Passenger | None:
    """Return the person aboard, None where there is none; raises `ConfigError`."""
    if not begin.local.is_on:
        return None
    hand = make_hand(begin.local, driver, clock)
    rules = hand_watchdog(begin.local, begin.robot, watchdog)
    if not begin.claim:
        return Passenger(hand, rules, clock)
    path = Path(begin.claim)
    return Passenger(hand, rules, clock, Claim(path), StopMark(path.with_suffix(".stopped")))


def hand_watchdog(
    local: LocalSettings, robot: RobotSettings, watchdog: DriverWatchdog
) -> HandWatchdog:
    """Return the watchdog that puts the person aboard above the server."""
    return HandWatchdog(watchdog, HandRules.of(local, robot, PERIOD_S))
