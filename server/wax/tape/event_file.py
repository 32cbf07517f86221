"""The events of one part, as an MCAP file (https://mcap.dev/spec) that Foxglove and others open.

It contains a JSON schema for each topic. Times are nanoseconds since 1970: the server's monotonic
clock plus an offset that is fixed while it runs, so that events stay in step with the picture even
if the machine's clock is set.

`flush` passes events to the operating system, where they survive a killed process; `sync` writes
them to disk, where they survive a power cut. A part that is being written is locked; an unlocked
one without an end was cut off (`event_ending.py`).
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Final

from mcap.writer import CompressionType, Writer

from wax import __version__, state_dir
from wax.protocol.tape_events import FORMAT, topic

if TYPE_CHECKING:
    from pathlib import Path
    from typing import IO

    from wax.protocol.tape_events import TapeEvent

METADATA: Final = "wax.tape"
"""The name of the first metadata record, whose keys are below."""
CUT: Final = "wax.tape.cut"
"""The name of the last metadata record of a file that was cut off and repaired later."""
VERSION: Final = "format"
ORIGIN: Final = "origin_ns"


def begin(file: IO[bytes], origin_ns: int) -> Writer:
    """Start a file of events whose time 0 is `origin_ns` since 1970; may raise `OSError`."""
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start(library=f"wax {__version__}")
    writer.add_metadata(METADATA, {VERSION: str(FORMAT), ORIGIN: str(origin_ns)})
    return writer


class EventFile:
    """A file that begins at `origin_s` on the server's clock, which was 0 at `zero_ns` since 1970.

    Not thread-safe. All methods may raise `OSError`.
    """

    def __init__(self, path: Path, *, origin_s: float, zero_ns: int) -> None:
        state_dir.make_private(path)
        self._zero_ns = zero_ns
        self._origin_ns = self._ns(origin_s)
        self._file = path.open("wb")
        try:
            with suppress(OSError):  # not every file system supports locks
                state_dir.lock(self._file, waits=True)
            self._file.truncate(0)  # a repair may have found it before the lock
            self._writer = begin(self._file, self._origin_ns)
            self._file.flush()
        except BaseException:
            self._file.close()
            raise
        self._channels: dict[type[TapeEvent], int] = {}

    def write(self, event: TapeEvent, at_s: float) -> None:
        """Add an event; one from before the beginning is dated at the beginning."""
        at_ns = max(self._ns(at_s), self._origin_ns)
        self._writer.add_message(
            self._channel(type(event)),
            log_time=at_ns,
            publish_time=at_ns,
            data=event.model_dump_json().encode(),
        )

    def flush(self) -> None:
        """Pass events to the operating system, so that they survive if this process is killed."""
        self._writer.flush()  # type: ignore[no-untyped-call]  # the library has no annotation

    def sync(self) -> None:
        """Write events to disk, so that they survive a power cut."""
        self.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Write the index and close the file; it is closed even if writing fails."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]  # as above
            self._file.flush()
            os.fsync(self._file.fileno())
        finally:
            self._file.close()

    def _channel(self, kind: type[TapeEvent]) -> int:
        channel = self._channels.get(kind)
        if channel is None:
            name = topic(kind)
            schema = self._writer.register_schema(
                f"wax.{kind.__name__}", encoding="jsonschema", data=_schema(kind)
            )
            channel = self._writer.register_channel(name, "json", schema)
            self._channels[kind] = channel
        return channel

    def _ns(self, at_s: float) -> int:
        return self._zero_ns + round(at_s * 1e9)


@cache
def _schema(kind: type[TapeEvent]) -> bytes:
    return json.dumps(kind.model_json_schema(mode="serialization")).encode()
