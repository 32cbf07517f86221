"""A serial line: a real pseudo-terminal behind a name of our own."""

from __future__ import annotations

import asyncio
import os
import pty
import tty
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@dataclass(frozen=True, slots=True)
class SerialLine:
    """The board's end of the line; `path` is what the server opens."""

    path: Path
    received: bytearray = field(default_factory=bytearray)


@contextmanager
def serial_line(folder: Path) -> Iterator[SerialLine]:
    """Have it plugged in inside the block, which needs a running event loop."""
    line = SerialLine(folder / "robot-line")
    board, port = pty.openpty()
    tty.setraw(port)
    line.path.symlink_to(os.ttyname(port))
    loop = asyncio.get_running_loop()
    loop.add_reader(board, lambda: line.received.extend(os.read(board, 4096)))
    try:
        yield line
    finally:
        loop.remove_reader(board)
        line.path.unlink()
        os.close(board)
        os.close(port)
