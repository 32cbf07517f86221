"""Detects how a file of events ends, and completes one that was cut off.

A killed server leaves neither index nor footer, and without them other readers reject the whole
file. Existing records are not rewritten: the torn last record is cut off, and the missing ones are
appended (https://mcap.dev/spec). An interrupted repair can be repeated.
"""

from __future__ import annotations

import io
import os
from contextlib import suppress
from typing import TYPE_CHECKING, BinaryIO, Final, Literal

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

from wax import state_dir
from wax.errors import StateError
from wax.tape.event_file import CUT, METADATA, begin
from wax.tape.reading import unpack

if TYPE_CHECKING:
    from pathlib import Path

Ending = Literal["whole", "mended", "open", "cut"]
"""Finished; repaired after it was cut off; being written; cut off."""

_LONGEST_BYTES: Final = 4_000_000
"""A longer record is not ours: its length is damaged, and nothing after it can be found."""
_BEGINNING_BYTES: Final = 1000
"""More than the first records of a file take."""
_DATA_KINDS: Final = (Opcode.HEADER, Opcode.METADATA, Opcode.CHUNK, Opcode.MESSAGE_INDEX)

_HEAD_BYTES: Final = 9
_FOOTER: Final = bytes([Opcode.FOOTER]) + (20).to_bytes(8, "little")
_FOOTER_BYTES: Final = len(_FOOTER) + 20 + len(MCAP0_MAGIC)
_TAIL_BYTES: Final = 1000
"""The metadata index lies within this many bytes of the end."""


def ending_of(path: Path) -> Ending:
    """Return how a file of events ends; raises `OSError`."""
    with path.open("rb") as file:
        end = _end_of(file)
        if end is not None:
            return end
        try:
            state_dir.lock(file, shared=True)
        except OSError:  # it is in use, or the lock cannot be checked: leave it alone
            return "open"
        return _end_of(file) or "cut"


def finish(file: BinaryIO, began_ns: int) -> None:
    """Complete a file that was cut off; one cut within its first records begins at `began_ns`.

    The caller holds the file's lock. Raises `OSError`, or `StateError` for a file that is not ours
    or that is damaged otherwise.
    """
    size = file.seek(0, os.SEEK_END)
    written = _Written(file, size)
    if written.is_only_cut and written.has(METADATA):
        added = _added(written, size)
        file.truncate(written.end)
        file.seek(written.end)
        file.write(added)
    elif written.is_only_cut and size <= _BEGINNING_BYTES:
        _rewrite_empty(file, began_ns)
    else:
        raise StateError("its events are damaged, not only cut off, and stay as they are")


def _end_of(file: BinaryIO) -> Ending | None:
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - _TAIL_BYTES))
    tail = file.read()
    if not tail.endswith(MCAP0_MAGIC) or not tail[-_FOOTER_BYTES:].startswith(_FOOTER):
        return None
    return "mended" if CUT.encode() in tail else "whole"


def _rewrite_empty(file: BinaryIO, began_ns: int) -> None:
    """Rewrite the file without events: it was cut off before the first of them."""
    file.truncate(0)
    file.seek(0)
    writer = begin(file, began_ns)
    writer.add_metadata(CUT, {})
    writer.finish()  # type: ignore[no-untyped-call]  # the library has no annotation


class _Written:
    """Scans a file for complete records; `end` is where the last of them ends.

    A damaged chunk stays in place, and no index refers to it.
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        file.seek(0)
        head = file.read(len(MCAP0_MAGIC))
        self.is_only_cut = MCAP0_MAGIC.startswith(head)
        self.end = len(head)
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.chunks: list[ChunkIndex] = []
        self.metadata: list[MetadataIndex] = []
        self.counts: dict[int, int] = {}
        self._chunk: tuple[ChunkIndex, set[int]] | None = None
        if self.is_only_cut:
            self._read(file, size)
        self._check_index()

    def has(self, metadata: str) -> bool:
        return any(one.name == metadata for one in self.metadata)

    def _read(self, file: BinaryIO, size: int) -> None:
        while self.end + _HEAD_BYTES <= size:
            file.seek(self.end)
            head = file.read(_HEAD_BYTES)
            kind, length = head[0], int.from_bytes(head[1:], "little")
            if kind == 0:  # after a power cut a file may end in zeros
                self.is_only_cut = not head.strip(b"\0") and not file.read().strip(b"\0")
                return
            if length > size - self.end - _HEAD_BYTES:
                self.is_only_cut = length <= _LONGEST_BYTES
                return
            if kind not in _DATA_KINDS:  # the beginning of an end that was not finished
                return
            self._check_index(kind)
            with suppress(Exception):  # damaged bytes make the library raise anything
                self._add_record(kind, file.read(length))
            self.end += _HEAD_BYTES + length

    def _add_record(self, kind: int, body: bytes) -> None:
        stream, length = ReadDataStream(io.BytesIO(body)), _HEAD_BYTES + len(body)
        if kind == Opcode.METADATA:
            self.metadata.append(MetadataIndex(self.end, length, Metadata.read(stream).name))
        elif kind == Opcode.CHUNK:
            self._add_chunk(Chunk.read(stream), length)
        elif kind == Opcode.MESSAGE_INDEX and self._chunk is not None:
            index, _ = self._chunk
            index.message_index_offsets[MessageIndex.read(stream).channel_id] = self.end
            index.message_index_length += length

    def _add_chunk(self, chunk: Chunk, length: int) -> None:
        channels: set[int] = set()
        for record in unpack(chunk):
            if isinstance(record, Schema):
                self.schemas[record.id] = record
            elif isinstance(record, Channel):
                self.channels[record.id] = record
            elif isinstance(record, Message):
                self.counts[record.channel_id] = self.counts.get(record.channel_id, 0) + 1
                channels.add(record.channel_id)
        index = ChunkIndex(
            chunk_start_offset=self.end,
            chunk_length=length,
            message_start_time=chunk.message_start_time,
            message_end_time=chunk.message_end_time,
            message_index_offsets={},
            message_index_length=0,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.uncompressed_size,
        )
        self.chunks.append(index)
        self._chunk = index, channels

    def _check_index(self, next_kind: int = 0) -> None:
        """Drop an incomplete index of a chunk: without one, readers scan the chunk itself."""
        if self._chunk is None or next_kind == Opcode.MESSAGE_INDEX:
            return
        index, channels = self._chunk
        self._chunk = None
        if index.message_index_offsets.keys() != channels:
            index.message_index_offsets.clear()
            index.message_index_length = 0


def _added(written: _Written, size: int) -> bytes:
    """Return the bytes to append: the mark of a cut, the end of data, and the summary."""
    added = RecordBuilder()
    if not written.has(CUT):
        Metadata(CUT, {"bytes": str(size - written.end)}).write(added)
        written.metadata.append(MetadataIndex(written.end, added.count, CUT))
    DataEnd(0).write(added)
    begins_at = written.end + added.count
    groups: dict[Opcode, list[McapRecord]] = {
        Opcode.SCHEMA: [*written.schemas.values()],
        Opcode.CHANNEL: [*written.channels.values()],
        Opcode.STATISTICS: [_statistics(written)],
        Opcode.CHUNK_INDEX: [*written.chunks],
        Opcode.METADATA_INDEX: [*written.metadata],
    }
    offsets = []
    for kind, records in groups.items():
        before = added.count
        for record in records:
            record.write(added)
        if records:
            offsets.append(SummaryOffset(kind, written.end + before, added.count - before))
    offsets_at = written.end + added.count
    for offset in offsets:
        offset.write(added)
    Footer(begins_at, offsets_at, 0).write(added)
    return bytes(added.end()) + MCAP0_MAGIC  # type: ignore[no-untyped-call]  # as above


def _statistics(written: _Written) -> Statistics:
    return Statistics(
        attachment_count=0,
        channel_count=len(written.channels),
        channel_message_counts=written.counts,
        chunk_count=len(written.chunks),
        message_count=sum(written.counts.values()),
        metadata_count=len(written.metadata),
        message_start_time=min((one.message_start_time for one in written.chunks), default=0),
        message_end_time=max((one.message_end_time for one in written.chunks), default=0),
        schema_count=len(written.schemas),
    )
