"""A file of what must stay in force when the server is restarted.

The Stop, and what the host has closed, blanked or limited. A restart after a fault asks nobody, so
it must not undo what somebody has ordered.
"""

from __future__ import annotations

import os
import threading
from typing import TYPE_CHECKING, Final

import structlog
from pydantic import ValidationError

from wax import state_dir
from wax.errors import StateError, reason_of
from wax.named_file import read_bytes
from wax.protocol.events import StopRole
from wax.protocol.host_switches import IN_DOUBT, HostSwitches
from wax.sentence import Sentence

if TYPE_CHECKING:
    from pathlib import Path
    from typing import TextIO

_LOG = structlog.get_logger(__name__)

FILE: Final = "in-force.json"
_LOCK: Final = "in-force.lock"
_AGAIN_S: Final = 10.0
"""A failed write is retried after this."""
_CLOSE_S: Final = 0.5
"""How long `close` waits for a slow disk."""
_FILE_BYTES: Final = 512
"""More than any state needs: a file of constant size can be overwritten on a full disk."""


class KeptState(HostSwitches):
    """`stop` is the role that pressed the Stop in force, "host" once the host has, too."""

    stop: StopRole | None = None

    @property
    def switches(self) -> HostSwitches:
        return HostSwitches(**self.model_dump(exclude={"stop"}))


_DOUBT: Final = KeptState(stop="host", **dict(IN_DOUBT))
"""What an unreadable file stands for: nobody drives, sees, hears or speaks."""


class KeptFile:
    """Writes the newest state in a thread: a disk may take longer than a Stop may.

    `state_folder` as configured; `before` is what the last server kept. The file is made at the
    start, so that a Stop has room even if the disk fills up.
    """

    def __init__(self, state_folder: str) -> None:
        self._path: Path | None = None
        self._unread = self._unwritten = ""
        try:
            self._path = state_dir.find(state_folder) / FILE
        except StateError as error:
            self._fail(error)
        self.before = self._read()
        self._kept: KeptState | None = None
        self._wanted = self.before
        self._lock: TextIO | None = None
        self._changed = threading.Event()
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name="kept state", daemon=True)

    def problems(self) -> list[Sentence]:
        """Return the problems that the host has to know."""
        told = []
        if self._unread:
            told.append(Sentence("kept.unread", {"why": self._unread}))
        if self._unwritten:
            told.append(Sentence("kept.unwritten", {"why": self._unwritten}))
        return told

    def start(self) -> None:
        """Start writing, unless another server has the folder: each would undo the other's Stop.

        That is then one of the `problems`.
        """
        try:
            self._claim()
        except (OSError, StateError) as error:
            self._fail(error)
        self._thread.start()

    def save(self, state: KeptState) -> None:
        """Have the thread write this state; returns at once."""
        if state != self._wanted:
            self._wanted = state
            self._changed.set()

    def close(self) -> bool:
        """Write and end the thread; return False if the disk is too slow. Safe to call twice."""
        self._is_closing = True
        self._changed.set()
        if self._thread.is_alive():
            self._thread.join(_CLOSE_S)
        return not self._thread.is_alive()

    def _claim(self) -> None:
        """Lock the folder, once; raise `OSError` while it cannot be used.

        Raise `StateError` if another server has it, or its file would be overwritten unread.
        """
        if self._path is None or self._lock is not None:
            return
        try:
            self._lock = _locked(state_dir.prepare(self._path.parent) / _LOCK)
        except BlockingIOError:
            why = "another server has the same [server] state_dir"
        else:
            if self.before is _DOUBT or self._read() == self.before:
                return
            why = f"{self._path} has changed since the start; start the server again"
        self._path = None
        raise StateError(why)

    def _run(self) -> None:
        while True:
            self._changed.clear()  # first, so that a change during the write is seen next time
            is_last, wanted = self._is_closing, self._wanted
            if wanted != self._kept or self._unwritten:
                self._write(wanted)
            if is_last:
                if self._lock is not None:
                    self._lock.close()
                return
            self._changed.wait(_AGAIN_S if self._unwritten else None)

    def _read(self) -> KeptState:
        if self._path is None:
            return KeptState()
        try:
            return KeptState.model_validate_json(read_bytes(self._path))
        except (FileNotFoundError, NotADirectoryError):
            return KeptState()
        except (OSError, ValidationError) as error:
            self._unread = f"{self._path}: {_reason_of(error)}"
            _LOG.warning("a Stop counts as in force", error=self._unread)
            return _DOUBT

    def _write(self, state: KeptState) -> None:
        """Write and sync at once: somebody who presses Stop may cut the power next."""
        if self._path is None:
            return
        content = state.model_dump_json().encode().ljust(_FILE_BYTES)
        try:
            self._claim()
            state_dir.prepare(self._path.parent)
            try:
                state_dir.replace(self._path, content)
            except OSError:
                if not _is_written_over(self._path, content):
                    raise
                state_dir.sync(self._path.parent)
        except (OSError, StateError) as error:
            self._kept = None  # the file may have been replaced all the same
            self._fail(error)
        else:
            self._kept, self._unwritten = state, ""

    def _fail(self, error: OSError | StateError) -> None:
        why = _reason_of(error)
        if why != self._unwritten:
            _LOG.warning("a Stop in force may end with the server", error=why)
        self._unwritten = why


def _reason_of(error: Exception) -> str:
    return "it is damaged" if isinstance(error, ValidationError) else reason_of(error)


def _is_written_over(path: Path, content: bytes) -> bool:
    """Overwrite the existing file, which works on a full disk; return whether it succeeded.

    A file that a power cut truncates is unreadable, and so counts as a Stop.
    """
    try:
        with os.fdopen(os.open(path, os.O_WRONLY), "wb") as file:
            file.write(content)
            file.truncate()
            file.flush()
            os.fsync(file.fileno())
    except OSError:
        return False
    return True


def _locked(path: Path) -> TextIO:
    """Return a file, locked for this process until it is closed; raises `OSError`."""
    file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "r+")
    try:
        state_dir.lock(file)
    except BlockingIOError:
        file.close()
        raise
    except OSError as error:  # not every file system has locks
        _LOG.debug("the state folder is not locked", error=str(error))
    return file
