"""Reads files that the configuration names, so that a wrong name is a sentence and never hangs.

Opening a pipe without a writer would block; a device such as /dev/zero never ends.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from pathlib import Path
from typing import Final

from wax.errors import StartError, reason_of
from wax.folders import expanded

TEXT_BYTES: Final = 1 << 20
"""Larger than any certificate, key, secret or configuration."""

_KINDS: Final = {
    stat.S_IFDIR: "it is a folder, not a file",
    stat.S_IFIFO: "it is a pipe, not a file",
    stat.S_IFSOCK: "it is a socket, not a file",
    stat.S_IFCHR: "it is a device, not a file",
    stat.S_IFBLK: "it is a device, not a file",
}


def check(path: Path) -> os.stat_result:
    """Return a regular file's status; raises `OSError`, whose `strerror` says why it is none."""
    try:
        found = path.stat()
    except ValueError:  # a null character
        raise OSError(errno.EINVAL, "no file has such a name") from None
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, _KINDS.get(stat.S_IFMT(found.st_mode), "it is not a file"))
    return found


def read_bytes(path: Path, most_bytes: int = TEXT_BYTES) -> bytes:
    """Return a file's content; raises `OSError` as `check`, or if it exceeds `most_bytes`."""
    check(path)
    # Non-blocking: if it has become a pipe since the check, the start does not hang.
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise OSError(errno.EFBIG, f"it has more than {most_bytes} bytes; is it the right file?")
    return content


def problem(error: OSError) -> str:
    """Return what is wrong, in words that follow the file's name."""
    if isinstance(error, FileNotFoundError):
        return "does not exist"
    return f"cannot be read: {reason_of(error)}"


def secret_file(name: str) -> Path:
    """Return the path of a named file, or of the copy that systemd gives a service.

    A service's user may be unable to read the file itself (systemd's `LoadCredential`).
    """
    given = _credentials()
    with contextlib.suppress(OSError):
        if given:
            check(copy := Path(given) / Path(name).name)
            return copy
    return expanded(name)


def is_credential(path: Path) -> bool:
    """Whether it is systemd's copy for this service, which has an access list for its mode."""
    return str(path.parent) == _credentials()


def _credentials() -> str:
    return os.environ.get("CREDENTIALS_DIRECTORY", "")


def read_secret(name: str) -> bytes:
    """Return a secret file's content; raises `OSError`, which tells a service how to get it."""
    path = secret_file(name)
    try:
        return read_bytes(path)
    except PermissionError as error:
        raise PermissionError(
            error.errno,
            f"{reason_of(error)}; a service of systemd gets it by a line in its unit:"
            f" LoadCredential={path.name}:{path.absolute()}",
        ) from error


def told_secret(key: str, name: str, advice: str = "") -> bytes:
    """Return a secret, stripped; raises `StartError` with the key's name and the advice."""
    try:
        secret = read_secret(name).strip()
    except OSError as error:
        raise StartError(f"{key}: {name} cannot be read: {reason_of(error)}{advice}") from error
    if not secret:
        raise StartError(f"{key}: {name} is empty{advice}")
    return secret


def told_text(key: str, name: str, advice: str) -> str:
    """Return a secret as text; raises `StartError` as `told_secret` does."""
    try:
        return told_secret(key, name, advice).decode()
    except UnicodeDecodeError as error:
        raise StartError(f"{key}: {name} holds no text{advice}") from error
