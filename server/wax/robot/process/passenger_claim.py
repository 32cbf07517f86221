"""Lets a driver process take over the robot from one that has outlived its server.

With a person aboard, the driver process keeps driving for them after the server has died. The next
server's process writes its mark into a file of the state directory; the older process reads it and
ends as soon as no hand is on the control. A lock on that file, which the system releases however a
process ends, keeps the new process from opening the robot before that.
"""

from __future__ import annotations

import fcntl
import os
import time
from typing import TYPE_CHECKING

import structlog

if TYPE_CHECKING:
    from pathlib import Path

_LOG = structlog.get_logger(__name__)


class Claim:
    """A mark of this process in the file `path`, and a lock on it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        # All marks have one length: each overwrites the last, and half a mark matches nobody's.
        self._mark = f"{os.getpid():10} {time.monotonic_ns():20}\n".encode()
        self._file: int | None = None
        self.is_taken = False
        """Whether the mark was written, so that another process can end this one."""

    def take(self) -> None:
        """Write the mark; if that fails, as on a full disk, the process ends with its server."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._file = os.open(self._path, os.O_CREAT | os.O_RDWR, 0o600)
            self.is_taken = os.pwrite(self._file, self._mark, 0) == len(self._mark)
        except OSError as error:
            _LOG.warning(
                "if the server dies, the person aboard cannot drive on: no mark can be kept",
                file=str(self._path),
                problem=str(error),
            )

    @property
    def is_held(self) -> bool:
        """Whether the newest mark is this process's; a deleted file changes nothing."""
        try:
            return self.is_taken and self._path.read_bytes() == self._mark
        except OSError:
            return self.is_taken

    def has_robot(self) -> bool:
        """Whether this process has the robot, or can now take it until it ends."""
        if self._file is None:
            return True
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
