"""The driver process: `python -m wax.robot.process`, started only by `ProcessDriver`.

It ends only when the pipe it reads from ends, however the server ended; with a person aboard it
keeps running for them after the server has died. It ignores the signals that a terminal or service
manager sends to all processes of the server, so that it can stop the robot.
"""

from __future__ import annotations

import os

import structlog

from wax.clock import SystemClock
from wax.errors import ConfigError
from wax.machine.priority import raise_priority
from wax.robot.build_driver import limits_of, make_driver
from wax.robot.process.child_loop import ChildLoop
from wax.robot.process.child_start import claim_pipes, first_line, log_as, outlive_signals, run
from wax.robot.process.driver_watchdog import DriverWatchdog
from wax.robot.process.passenger import make_passenger
from wax.robot.process.pipe_messages import NotBuilt, decode_begin, encode
from wax.robot.process.robot_lock import RobotLock

_LOG = structlog.get_logger(__name__)


def main() -> int:
    """Run one robot until the pipe ends; returns 1 if its driver cannot be built."""
    outlive_signals()
    reader, writer = claim_pipes()
    line = first_line(reader)
    if line is None:
        return 0
    begin = decode_begin(line)
    log_as(begin.log, "the robot's driver")
    clock = SystemClock()
    try:
        driver = make_driver(begin.robot, clock)
        limits = limits_of(driver, begin.robot)
        watchdog = DriverWatchdog(limits, begin.robot.silence_ms / 1000.0, begin.controls)
        passenger = make_passenger(begin, driver, watchdog, clock)
    except ConfigError as error:
        _LOG.error("the driver cannot be built", problem=str(error))
        os.write(writer, encode(NotBuilt(why=str(error))))
        return 1
    # From here set-points must not wait for the encoder; loading the driver, above, may.
    raise_priority()
    os.set_blocking(reader, False)
    os.set_blocking(writer, False)
    ChildLoop(
        driver,
        watchdog,
        clock,
        reader=reader,
        writer=writer,
        passenger=passenger,
        lock=RobotLock(begin.robot),
    ).run()
    return 0


if __name__ == "__main__":
    run(main, "the driver process")
