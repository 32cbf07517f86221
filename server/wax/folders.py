"""Folders that a bare machine may lack: a home, and one for temporary files."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path

from wax.errors import StateError, reason_of


def expanded(name: str) -> Path:
    """Return the path with ``~`` for a home directory; unchanged where there is no such home.

    A user of a container often has no name, and no ``$HOME``.
    """
    with contextlib.suppress(RuntimeError):
        return Path(name).expanduser()
    return Path(name)


def temporary(prefix: str) -> tempfile.TemporaryDirectory[str]:
    """Make a folder that ends with the object; raises `StateError` where none can be made."""
    try:
        return tempfile.TemporaryDirectory(prefix=prefix)
    except OSError as error:
        raise StateError(
            f"temporary files cannot be written ({reason_of(error)}); name a folder for them"
            " by the environment variable TMPDIR"
        ) from error
