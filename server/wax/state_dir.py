"""The folder for what outlives the server: its records and its secrets, for its owner only."""

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
    """Return the folder: as configured, else systemd's (systemd.exec, StateDirectory=), else XDG's.

    It need not exist. Raises `StateError` if nothing says where it is.
    """
    if configured:
        return _at_home(configured)
    if given := environment.get("STATE_DIRECTORY", ""):
        return Path(given.split(":")[0])
    # XDG Base Directory: a relative path counts as none.
    home = Path(environment.get("XDG_STATE_HOME", ""))
    if home.is_absolute():
        return home / "wax"
    return _at_home("~/.local/state/wax")


def prepare(folder: Path) -> Path:
    """Make the folder, closed to others, and return it; raises `StateError` with what to do.

    One that is there stays as open as it is: it may be shared, and each file in it is private.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise _unusable(folder, reason_of(error)) from error
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise _unusable(folder, "this user may not write there")
    return folder


def make_private(path: Path) -> None:
    """Make a file that only its owner can read, unless it is there; raises `OSError`."""
    with contextlib.suppress(FileNotFoundError):
        check(path)  # as root, /dev/null would be closed to everybody
    os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    if path.stat().st_mode & 0o077:
        path.chmod(0o600)


def replace(path: Path, data: bytes, mode: int = 0o600) -> None:
    """Replace a file at once and for good: a power cut leaves the old one or this one, whole.

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
    """Return when what is in a file, or which files a folder has, outlasts a power cut.

    Without this Linux writes it within half a minute. Raises `OSError`.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # not every file system can do so with a folder
            raise
    finally:
        os.close(descriptor)


def lock(file: IO[Any], *, waits: bool = False, shared: bool = False) -> None:
    """Have a file alone until it is closed, which the end of the process does, too.

    `shared` with whoever also only looks. Raises `BlockingIOError` while somebody else has it,
    unless this `waits`; `OSError` where the file system has no locks.
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
