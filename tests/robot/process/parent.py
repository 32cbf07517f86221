"""A minimal server: it holds a robot and obeys orders on its standard input.

Started as ``python -m tests.robot.process.parent SETTINGS LOCAL CLAIM``: the `RobotSettings` and
`LocalSettings` as JSON, and the file by which a driver process takes over from another.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import time
from typing import Any, Final

from tests.robot.process import recorder

from wax.clock import SystemClock
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.build_driver import limits_of
from wax.robot.process.driver import ProcessDriver

TWISTS: Final = {
    "stand": STANDSTILL,
    "leave": STANDSTILL,
    "drive": Twist(0.5, 0.0),
    "silence": None,
}


def process_driver(settings: RobotSettings, **more: Any) -> ProcessDriver:
    """Build what `make_robot` drives by, without a process that looks at somebody's own driver."""
    known = getattr(recorder, settings.driver.partition(":")[2])
    limits = limits_of(known, settings)
    return ProcessDriver(settings, SystemClock(), kind=known.kind, limits=limits, **more)


def main() -> None:
    # A background job inherits an ignored SIGINT.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    robot = process_driver(
        RobotSettings.model_validate_json(sys.argv[1]),
        local=LocalSettings.model_validate_json(sys.argv[2]),
        claim=sys.argv[3],
    )
    robot.tell_passenger(is_operated=True)
    robot.open()
    while not robot.state().connected:
        time.sleep(0.005)
    twist: Twist | None = STANDSTILL
    words: list[str] = []
    while True:
        if twist is not None:
            robot.apply(twist, 1)
        # Read unbuffered: of two words that came at once, `select` would not see the second.
        if not words and select.select([0], [], [], 0.02)[0]:
            words = os.read(0, 4096).decode().split() or ["close"]  # nobody is left to tell it
        word = words.pop(0) if words else ""
        if word == "abandon":
            robot.abandon()
            return
        if word == "close":
            robot.close()
            return
        if word == "leave":
            robot.tell_passenger(is_operated=False)
        twist = TWISTS.get(word, twist)


if __name__ == "__main__":
    main()
