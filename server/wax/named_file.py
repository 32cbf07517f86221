"""Files that the host has named: read so that a wrong name is a sentence, never a start that hangs.

A pipe that nobody writes into holds up whoever opens it; a device such as /dev/zero never ends.
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
"""More than any certificate, key, secret or configuration has."""

_KINDS: Final = {
    stat.S_IFDIR: "it is a folder, not a file",
    stat.S_IFIFO: "it is a pipe, not a file",
    stat.S_IFSOCK: "it is a socket, not a file",
    stat.S_IFCHR: "it is a device, not a file",
    stat.S_IFBLK: "it is a device, not a file",
}


def check(path: Path) -> os.stat_result:
    """Return what is known of a file; raises `OSError`, whose `strerror` says why it is none."""
    try:
        found = path.stat()
    except ValueError:  # a null character
        raise OSError(errno.EINVAL, "no file has such a name") from None
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, _KINDS.get(stat.S_IFMT(found.st_mode), "it is not a file"))
    return found


def read_bytes(path: Path, most_bytes: int = TEXT_BYTES) -> bytes:
    """Return what is in a file, of at most `most_bytes`; raises `OSError` as `check` does."""
    check(path)
    # Not blocking: should it have become a pipe meanwhile, the start does not hang.
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise OSError(errno.EFBIG, f"it has more than {most_bytes} bytes; is it the right file?")
    return content


def problem(error: OSError) -> str:
    """Return what is wrong, to follow the file's name in a sentence."""
    if isinstance(error, FileNotFoundError):
        return "does not exist"
    return f"cannot be read: {reason_of(error)}"


def secret_file(name: str) -> Path:
    """Return the file as it is named, or what systemd gives a service of it (`LoadCredential`).

    A service's user may not read the file itself.
    """
    given = _credentials()
    with contextlib.suppress(OSError):
        if given:
            check(copy := Path(given) / Path(name).name)
            return copy
    return expanded(name)


def is_credential(path: Path) -> bool:
    """Whether systemd has given it to this service, with an access list in place of a mode."""
    return str(path.parent) == _credentials()


def _credentials() -> str:
    return os.environ.get("CREDENTIALS_DIRECTORY", "")


def read_secret(name: str) -> bytes:
    """Return what is in a secret's file; raises `OSError`, which says how a service gets at it."""
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
    """Return a secret without white space; raises `StartError`, which names the key and advises."""
    try:
        secret = read_secret(name).strip()
    except OSError as error:
        raise StartError(f"{key}: {name} cannot be read: {reason_of(error)}{advice}") from error
    if not secret:
        raise StartError(f"{key}: {name} is empty{advice}")
    return secret


def told_text(key: str, name: str, advice: str) -> str:
    """Return a secret that is text; raises `StartError` as `told_secret` does."""
    try:
        return told_secret(key, name, advice).decode()
    except UnicodeDecodeError as error:
        raise StartError(f"{key}: {name} holds no text{advice}") from error
