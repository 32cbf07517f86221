"""The state folder, for files that outlive the server: records and secrets, for its owner only."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wax.errors import StateError, reason_of
from wax.folders import expanded
from wax.named_file import check

if sys.platform != "win32":
    import fcntl

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import IO


def find(configured: str = "", environment: Mapping[str, str] = os.environ) -> Path:
    """Return the configured folder, else systemd's (systemd.exec, StateDirectory=), else XDG's.

    It need not exist. Raises `StateError` if none of these is set.
    """
    if configured:
        return _at_home(configured)
    if given := environment.get("STATE_DIRECTORY", ""):
        return Path(given.split(":")[0])
    # XDG Base Directory: a relative path is ignored.
    home = Path(environment.get("XDG_STATE_HOME", ""))
    if home.is_absolute():
        return home / "wax"
    return _at_home("~/.local/state/wax")


def prepare(folder: Path) -> Path:
    """Create the folder, closed to others, and return it; raises `StateError` with advice.

    An existing folder keeps its mode: it may be shared, and each file in it is private.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise _unusable(folder, reason_of(error)) from error
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise _unusable(folder, "this user may not write there")
    return folder


def make_private(path: Path) -> None:
    """Create a file if it is missing, and close it to all but its owner; raises `OSError`."""
    with contextlib.suppress(FileNotFoundError):
        check(path)  # as root, we would close /dev/null to everybody
    os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    if path.stat().st_mode & 0o077:
        path.chmod(0o600)


def replace(path: Path, data: bytes, mode: int = 0o600) -> None:
    """Replace a file atomically and durably: a power cut leaves the old one or this one, whole.

    Raises `OSError`.
    """
    new = path.with_suffix(".new")
    new.unlink(missing_ok=True)
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(data)
    sync(new)
    new.replace(path)
    sync(path.parent)


def sync(path: Path) -> None:
    """Flush a file's content, or a folder's entries, to disk, so that it survives a power cut.

    Without this, Linux writes it within half a minute. Raises `OSError`.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some file systems cannot flush a folder
            raise
    finally:
        os.close(descriptor)


def lock(file: IO[Any], *, waits: bool = False, shared: bool = False) -> None:
    """Lock a file until it is closed, or the process ends.

    A `shared` lock excludes only exclusive ones. Raises `BlockingIOError` if another process has
    it, unless this `waits`; `OSError` if the file system has no locks.
    """
    how = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    fcntl.flock(file, how if waits else how | fcntl.LOCK_NB)


def _at_home(name: str) -> Path:
    path = expanded(name)
    if str(path).startswith("~"):
        raise _unusable(path, "there is no such home directory")
    return path


def _unusable(folder: Path, why: str) -> StateError:
    return StateError(f"{folder}: {why}; name another folder with [server] state_dir")
