"""The Stop of the person aboard outlives the process that heard it, as a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import structlog

if TYPE_CHECKING:
    from pathlib import Path

_LOG = structlog.get_logger(__name__)


class StopMark:
    """The file `path`, which is there while the Stop is in force.

    So nobody but the person releases it: no server that is started again, and no driver process
    that has failed. It is not forced onto the disk, which takes long: a power cut may lose it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._kept: bool | None = None

    @property
    def is_set(self) -> bool:
        """Whether the file is there; a folder that cannot be read counts as if it were."""
        try:
            self._path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True
        return True

    def keep(self, is_stopped: bool) -> None:
        """Make or remove the file if that has changed; never raises."""
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
