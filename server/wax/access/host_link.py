"""Gives new host links to anyone with access to this user's files: `wax host-link`.

It is a Unix socket in the state folder, for its owner only, that sends the links to each client.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from pathlib import Path
from typing import TYPE_CHECKING, Final

import structlog

from wax import state_dir
from wax.errors import StateError, reason_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_LOG = structlog.get_logger(__name__)

SOCKET: Final = "host.sock"
_LONGEST_PATH: Final = 100
"""A Unix socket's path has at most 108 bytes on Linux, 104 on macOS."""
_ANSWER_S: Final = 3.0
_MAX_CHARS: Final = 65_536


class HostLinkSocket:
    """Serves from `open` to `close`; `make` returns links, which share one secret.

    `state` is the configured state folder.
    """

    def __init__(self, state: str, make: Callable[[], list[str]]) -> None:
        self._state = state
        self._path: Path | None = None
        self._make = make
        self._server: asyncio.Server | None = None

    @property
    def is_open(self) -> bool:
        return self._server is not None

    async def open(self) -> None:
        """Start serving; a failure is only a warning, since everything else works without it."""
        try:
            self._server = await asyncio.start_unix_server(self._answer, sock=self._bound())
        except (OSError, StateError, AttributeError) as error:
            _LOG.warning("`wax host-link` cannot reach this server", error=str(error))

    async def close(self) -> None:
        """Stop serving and remove the socket's file."""
        if self._server is None:
            return
        self._server.close()
        self._server = None
        if self._path is not None:
            with contextlib.suppress(OSError):
                self._path.unlink()

    def _bound(self) -> socket.socket:
        """Return the bound socket, never open to other users; raises `OSError`."""
        self._path = state_dir.prepare(state_dir.find(self._state)) / SOCKET
        self._path.unlink(missing_ok=True)
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        before = os.umask(0o177)
        try:
            with _short(self._path.parent) as folder:
                listening.bind(f"{folder}/{SOCKET}")
        except OSError:
            listening.close()
            raise
        finally:
            os.umask(before)
        return listening

    async def _answer(self, _: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError):
            writer.write("".join(f"{link}\n" for link in self._make()).encode())
            writer.close()
            await writer.wait_closed()
        _LOG.info("a host link was made")


def request_links(folder: Path) -> list[str]:
    """Ask the running server for a new host's links; raises `StateError`."""
    try:
        with _short(folder) as short, socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
            end.settimeout(_ANSWER_S)
            end.connect(f"{short}/{SOCKET}")
            with end.makefile("r", encoding="utf-8") as lines:
                links = lines.read(_MAX_CHARS).split()
    except (OSError, AttributeError) as error:
        raise StateError(
            f"{folder / SOCKET}: no server answers ({reason_of(error)}); is it running, as this"
            " user and with this configuration?"
        ) from error
    if not links:
        raise StateError(f"{folder / SOCKET}: the server sent nothing; see its log")
    return links


@contextlib.contextmanager
def _short(folder: Path) -> Iterator[str]:
    """Yield a path to the folder that is short enough for a Unix socket in it."""
    if len(str(folder)) + len(SOCKET) < _LONGEST_PATH or not Path("/proc/self/fd").is_dir():
        yield str(folder)
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)
