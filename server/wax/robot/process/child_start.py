"""The start of our child processes: they ignore a terminal's signals and keep their own pipes."""

from __future__ import annotations

import logging
import os
import signal
import sys
from typing import TYPE_CHECKING, Final, NoReturn

import structlog

from wax.logs.handler import PrintedLines
from wax.telemetry import configure_logs

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.log import LogSettings

_LOG = structlog.get_logger(__name__)

READ_BYTES: Final = 65_536


def outlive_signals() -> None:
    """Ignore what a terminal or service manager sends to all processes of the server."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)


def claim_pipes() -> tuple[int, int]:
    """Reserve both pipes for messages: other output goes to the log, other input is empty."""
    reader, writer = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return reader, writer


def first_line(reader: int) -> bytes | None:
    """Wait for the first line; None if the pipe ends before."""
    line = b""
    while not line.endswith(b"\n"):
        data = os.read(reader, READ_BYTES)
        if not data:
            return None
        line += data
    return line


def run(main: Callable[[], int], name: str) -> NoReturn:
    """Exit with what `main` returns, without waiting for threads that a plug-in left running."""
    status = 1
    try:
        status = main()
    except Exception:
        _LOG.exception(f"{name} failed")
    finally:
        logging.shutdown()
        os._exit(status)


def log_as(settings: LogSettings, who: str) -> None:
    """Write the log as the server does; each printed line becomes a log line."""
    configure_logs(settings)
    sys.stdout = sys.stderr = PrintedLines(lambda line: _LOG.info(f"{who} prints", line=line))
