"""The looking process: `python -m wax.robot.look`, started only by `wax.robot.known.look`.

It builds a driver, reports its properties, and ends.
"""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from wax.clock import SystemClock
from wax.errors import ConfigError, PluginError
from wax.robot.build_driver import make_driver
from wax.robot.known import Known, LookResult
from wax.robot.process.child_start import claim_pipes, first_line, log_as
from wax.robot.process.pipe_messages import decode_begin

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings


def main() -> None:
    """Build one driver and report it."""
    reader, writer = claim_pipes()
    line = first_line(reader)
    if line is None:
        return
    begin = decode_begin(line)
    log_as(begin.log, "the robot's driver")
    told = _seen(begin.robot).model_dump_json().encode()
    while told:
        told = told[os.write(writer, told) :]


def _seen(settings: RobotSettings) -> LookResult:
    try:
        driver = make_driver(settings, SystemClock())
        return LookResult(known=Known.of(driver, settings))
    except PluginError as error:
        return LookResult(failed=str(error))
    except ConfigError as error:
        return LookResult(refused=str(error))
    except Exception as error:  # a property may raise anything
        return LookResult(failed=f"robot.driver: {settings.driver} cannot be looked at: {error!r}")


if __name__ == "__main__":
    try:
        main()
    finally:
        logging.shutdown()
        os._exit(0)  # a thread that a plug-in left behind must not keep the process alive
