"""Folders that may be missing on a bare machine: a home, and one for temporary files."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path

from wax.errors import StateError, reason_of


def expanded(name: str) -> Path:
    """Return the path with ``~`` expanded; unchanged if there is no such home directory.

    A container's user often has no name and no ``$HOME``.
    """
    with contextlib.suppress(RuntimeError):
        return Path(name).expanduser()
    return Path(name)


def temporary(prefix: str) -> tempfile.TemporaryDirectory[str]:
    """Create a folder that is deleted with the object; raises `StateError` if that fails."""
    try:
        return tempfile.TemporaryDirectory(prefix=prefix)
    except OSError as error:
        raise StateError(
            f"temporary files cannot be written ({reason_of(error)}); name a folder for them"
            " by the environment variable TMPDIR"
        ) from error
