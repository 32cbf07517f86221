"""The folder for what outlives the server: its records and its secrets, for its owner only."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from wax.errors import StateError, reason_of
from wax.folders import expanded
from wax.named_file import check

if TYPE_CHECKING:
    from collections.abc import Mapping


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


def _at_home(name: str) -> Path:
    path = expanded(name)
    if str(path).startswith("~"):
        raise _unusable(path, "there is no such home directory")
    return path


def _unusable(folder: Path, why: str) -> StateError:
    return StateError(f"{folder}: {why}; name another folder with [server] state_dir")
