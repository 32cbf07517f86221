"""Stores the Stop of the person aboard in a file, so that it outlives the driver process."""

from __future__ import annotations

from typing import TYPE_CHECKING

import structlog

if TYPE_CHECKING:
    from pathlib import Path

_LOG = structlog.get_logger(__name__)


class StopMark:
    """The file `path`, which exists while the Stop is in force.

    So only the person can release it, even if the server restarts or the driver process fails. The
    file is not synced to disk, which would take long, so a power cut may lose it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._kept: bool | None = None

    @property
    def is_set(self) -> bool:
        """Whether the file exists; if the folder cannot be read, it counts as existing."""
        try:
            self._path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True
        return True

    def keep(self, is_stopped: bool) -> None:
        """Create or remove the file if the state has changed; never raises."""
        if is_stopped == self._kept:
            return
        self._kept = is_stopped
        try:
            if is_stopped:
                self._path.touch(mode=0o600)
            else:
                self._path.unlink(missing_ok=True)
        except OSError as error:
            _LOG.warning(
                "when this process ends it is forgotten whether the person aboard has pressed Stop",
                file=str(self._path),
                problem=str(error),
            )
