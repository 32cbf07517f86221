"""A serial line that can be unplugged: a real pseudo-terminal behind a name of our own."""

from __future__ import annotations

import asyncio
import os
import pty
import tty
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from pathlib import Path


class SerialLine:
    """The board's end of the line, plugged in inside its block; `path` is what the server opens.

    Needs a running event loop.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / "robot-line"
        self.received = bytearray()
        self._board: int | None = None
        self._port: int | None = None

    def __enter__(self) -> Self:
        self.plug()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def plug(self) -> None:
        self._board, self._port = pty.openpty()
        tty.setraw(self._port)
        self.path.symlink_to(os.ttyname(self._port))
        asyncio.get_running_loop().add_reader(self._board, self._take)

    def unplug(self) -> None:
        """Pull the plug: the name is gone, and an open port hangs up. Safe to call twice."""
        if self._board is None or self._port is None:
            return
        asyncio.get_running_loop().remove_reader(self._board)
        self.path.unlink()
        os.close(self._board)
        os.close(self._port)
        self._board = self._port = None

    def _take(self) -> None:
        assert self._board is not None
        self.received += os.read(self._board, 4096)
