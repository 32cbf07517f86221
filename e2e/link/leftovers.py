"""Finds what runs in our namespaces, by the namespace and not by name, and ends it."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

import psutil

if TYPE_CHECKING:
    from collections.abc import Iterator

MARK: Final = "WAX_LAB_LINK"
"""Set in the environment of each process of a link: the link's owner, as `owner` writes it."""

_ASK_FOR_S: Final = 1.0
_FORCE_FOR_S: Final = 3.0
_LOOK_EVERY_S: Final = 0.02

Namespace = tuple[int, int]
"""Device and inode of a namespace's file."""


def owner() -> str:
    """Return what identifies this process for ever: its id, and when it started."""
    return f"{os.getpid()}:{_started(os.getpid())}"


def namespace_of(file: int | str) -> Namespace:
    """Return the namespace of a descriptor or of a path; raises `OSError`."""
    found = os.stat(file)  # noqa: PTH116  # no Path is a descriptor
    return found.st_dev, found.st_ino


def end_all(namespaces: set[Namespace], *, but: int | None = None) -> None:
    """End every process in these network namespaces, gently first; blocks up to 4 s.

    The namespaces must be held open, so that no other namespace gets their number meanwhile.
    """
    for how, for_s in ((signal.SIGTERM, _ASK_FOR_S), (signal.SIGKILL, _FORCE_FOR_S)):
        asked: set[int] = set()
        until_s = time.monotonic() + for_s
        while time.monotonic() < until_s:
            left = {pid for pid, namespace in _networks() if namespace in namespaces} - {but}
            if not left:
                return
            for pid in left - asked if how is signal.SIGTERM else left:
                with suppress(ProcessLookupError, PermissionError):
                    os.kill(pid, how)
            asked |= left
            time.sleep(_LOOK_EVERY_S)


def end_stale() -> None:
    """End the leftovers of links whose owners were killed; their namespaces disappear with them."""
    own = _network(os.getpid())
    stale: set[Namespace] = set()
    held: list[int] = []
    try:
        for pid, namespace in _networks():
            made_by = _mark(pid)
            if made_by is None or _is_alive(made_by) or namespace in stale | {own}:
                continue
            try:
                held.append(os.open(f"/proc/{pid}/ns/net", os.O_RDONLY | os.O_CLOEXEC))
            except OSError:
                continue  # it ended meanwhile; the others have not
            if namespace_of(held[-1]) == namespace:
                stale.add(namespace)
        if stale:
            end_all(stale)
    finally:
        for descriptor in held:
            os.close(descriptor)


def _networks() -> Iterator[tuple[int, Namespace]]:
    """Yield each process that we may inspect; those that are ending have no namespace."""
    for pid in psutil.pids():
        if (namespace := _network(pid)) is not None:
            yield pid, namespace


def _network(pid: int) -> Namespace | None:
    with suppress(OSError):
        return namespace_of(f"/proc/{pid}/ns/net")
    return None


def _mark(pid: int) -> str | None:
    with suppress(psutil.Error):
        found: str | None = psutil.Process(pid).environ().get(MARK)
        return found
    return None


def _is_alive(made_by: str) -> bool:
    pid, _, started = made_by.partition(":")
    return pid.isdecimal() and _started(int(pid)) == started


def _started(pid: int) -> str:
    """Return when a process started, in ticks since boot; empty when there is none."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    return text.rpartition(")")[2].split()[19]  # proc(5): field 22; the name may have spaces
