"""The driver process: `python -m wax.robot.process`, started only by `ProcessDriver`.

It ends only when the pipe it reads from ends, however the server ended; with a person aboard it
goes on for them after a server that died. It ignores the signals that a terminal or service manager
sends to all processes of the server, so that it can stop the robot.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import sys
from typing import Final

import structlog

from wax.clock import SystemClock
from wax.errors import ConfigError
from wax.log_handler import PrintedLines
from wax.robot.find_driver import make_driver
from wax.robot.process.child_loop import READ_BYTES, ChildLoop
from wax.robot.process.driver_watchdog import DriverWatchdog
from wax.robot.process.passenger import make_passenger
from wax.robot.process.pipe_messages import Begin, decode_begin
from wax.telemetry import configure_logs

_LOG = structlog.get_logger(__name__)

NICENESS: Final = -10


def main() -> int:
    """Run one robot until the pipe ends; returns 1 if its driver cannot be built."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    # A set-point must not wait for the encoder, which uses all the CPU time it gets. Most users may
    # not raise the priority; then the robot's own watchdog covers an overloaded machine.
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    reader, writer = _pipes()
    begin = _begin(reader)
    if begin is None:
        return 0
    configure_logs(begin.log)
    sys.stdout = sys.stderr = PrintedLines(_LOG.info)
    clock = SystemClock()
    try:
        driver = make_driver(begin.robot, clock)
        watchdog = DriverWatchdog(driver.limits, begin.robot.silence_ms / 1000.0)
        passenger = make_passenger(begin, driver, watchdog, clock)
    except ConfigError as error:
        _LOG.error("the driver cannot be built", problem=str(error))
        return 1
    os.set_blocking(reader, False)
    os.set_blocking(writer, False)
    ChildLoop(driver, watchdog, clock, reader=reader, writer=writer, passenger=passenger).run()
    return 0


def _pipes() -> tuple[int, int]:
    """Keep both pipes to ourselves: other output goes to the log, other input is empty."""
    reader, writer = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return reader, writer


def _begin(reader: int) -> Begin | None:
    """Wait for the first line; None if there is none. Raises `ProtocolError`."""
    line = b""
    while not line.endswith(b"\n"):
        data = os.read(reader, READ_BYTES)
        if not data:
            return None
        line += data
    return decode_begin(line)


if __name__ == "__main__":
    status = 1
    try:
        status = main()
    except Exception:
        _LOG.exception("the driver process failed")
    finally:
        logging.shutdown()
        os._exit(status)  # a thread that a plug-in left behind must not keep the process alive
