"""The standby: `python -m wax.robot.ros2.standby`, started only by `StandbyProcess`.

It has a publisher of its own on the command topic, matched with the robot in advance, and is silent
while the driver sends. When the driver is frozen or has ended, however it ended, the standby sends
standstill. After the driver's end it then exits: so standstill lasts longer than closing may take.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from typing import TYPE_CHECKING, Final

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL
from wax.errors import DriverError
from wax.machine.priority import raise_priority
from wax.robot.ros2.command_topic import STANDBY
from wax.robot.ros2.open_link import load, open_link
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby_rules import StandbyRules

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.robot.ros2.link import Link

READ_BYTES: Final = 4096
LOOK_S: Final = 0.1
NOBODY: Final = "- 0"
"""What it reports while it has no connection."""


class Standby:
    """Reads from the driver on `reader`, and reports on `writer` how many subscribers it reaches.

    It reports at every check, changed or not: silence means that it is frozen or hangs.
    """

    def __init__(self, settings: Ros2Settings, clock: Clock, reader: int, writer: int) -> None:
        self._settings = settings
        self._clock = clock
        self._reader = reader
        self._writer = writer
        self._rules = StandbyRules(rate_hz=settings.rate_hz, zeros_s=settings.zeros_s)
        self._is_over = False

    def run(self) -> None:
        """Run until the driver has ended and standstill was sent for long enough."""
        while not self._is_done():
            try:
                link = open_link(self._settings, self._clock, mark=STANDBY)
            except DriverError:
                self._rest()
                continue
            try:
                self._stand(link)
            except DriverError:
                self._rest()
            finally:
                with contextlib.suppress(DriverError):
                    link.close()

    def _rest(self) -> None:
        self._say(NOBODY)
        self._listen(self._settings.reopen_s)

    def _is_done(self) -> bool:
        return self._rules.is_over(self._clock.now_s())

    def _stand(self, link: Link) -> None:
        look_s = self._clock.now_s()
        while not self._is_done():
            now_s = self._clock.now_s()
            if now_s >= look_s:
                look_s = now_s + LOOK_S
                self._tell(link)
            is_due, again_s = self._rules.next(now_s)
            if is_due:
                link.send(STANDSTILL, time.time_ns())
            self._listen(min(again_s, look_s) - self._clock.now_s())

    def _listen(self, pause_s: float) -> None:
        """Wait up to this time for a message or the end of the driver."""
        if self._is_over:
            time.sleep(max(0.0, pause_s))
            return
        if not select.select([self._reader], [], [], max(0.0, pause_s))[0]:
            return
        words = os.read(self._reader, READ_BYTES)
        if words:
            self._rules.handle_reports(words, self._clock.now_s())
        else:
            self._is_over = True
            self._rules.ended(self._clock.now_s())

    def _tell(self, link: Link) -> None:
        matched = link.traffic().matched
        self._say(f"{link.guid or '-'} {'-' if matched is None else matched}")

    def _say(self, words: str) -> None:
        with contextlib.suppress(OSError):  # the driver has ended, or is frozen and the pipe full
            os.write(self._writer, f"{words}\n".encode())


def main() -> None:
    """Run until the driver has ended."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    # Output of a library, such as CycloneDDS's traces, must not be taken for our reports.
    writer = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    os.set_blocking(writer, False)  # a frozen driver must not freeze us
    settings = Ros2Settings.model_validate_json(sys.stdin.buffer.readline())
    load(settings)
    raise_priority()
    Standby(settings, SystemClock(), sys.stdin.fileno(), writer).run()


if __name__ == "__main__":
    main()
