"""One driver process takes the robot over from another that has outlived its server.

Where a person is aboard, the driver process drives on for them when the server has died. The
process of the next server writes its mark into a file of the state directory; the older one reads
it there and ends as soon as no hand is on the control. A lock, which the system releases however a
process ends, keeps the new one from opening the robot before that.
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
    """A mark of this process in the file `path`, and the lock beside it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._mark = f"{os.getpid()} {time.monotonic_ns()}\n"
        self._lock: int | None = None

    def take(self) -> None:
        """Write the mark; where that fails, as on a full disk, the process ends with its server."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            new = self._path.with_suffix(f".{os.getpid()}")
            new.write_text(self._mark)
            new.replace(self._path)  # at once, so that nobody reads half a mark
            self._lock = os.open(self._path.with_suffix(".lock"), os.O_CREAT | os.O_RDWR, 0o600)
        except OSError as error:
            _LOG.warning(
                "if the server dies, the person aboard cannot drive on: no mark can be kept",
                file=str(self._path),
                problem=str(error),
            )

    @property
    def is_taken(self) -> bool:
        """Whether there is a mark, by which others can end this process."""
        return self._lock is not None

    @property
    def is_held(self) -> bool:
        """Whether the newest mark is this one's; a file that is gone takes nothing away."""
        try:
            return self.is_taken and self._path.read_text() == self._mark
        except OSError:
            return self.is_taken

    def has_robot(self) -> bool:
        """Whether no other process has the robot; then it is this one's until it ends."""
        if self._lock is None:
            return True
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
