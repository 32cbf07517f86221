"""A standard error that is paused, as by Ctrl-S or by a reader that does not read."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def full_pipe() -> Iterator[int]:
    """Yield the writing end of a pipe that nobody reads and that accepts no more bytes."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    for size in (65_536, 1):
        with suppress(BlockingIOError):
            while True:
                os.write(writer, b"." * size)
    os.set_blocking(writer, True)
    try:
        yield writer
    finally:
        os.close(reader)
        os.close(writer)
