"""Reads the events of one part, even if it was cut off, and reports what is unreadable.

A tape may come from anybody, so nothing is decompressed before its size is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import zstandard
from mcap.records import Channel, Chunk, Footer, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk

from wax.errors import ProtocolError, StateError, reason_of
from wax.protocol.tape_events import EVENTS, FORMAT, Placed, parse_event, topic
from wax.tape.event_file import CUT, METADATA, ORIGIN, VERSION

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path
    from typing import IO

    from mcap.records import McapRecord

    from wax.protocol.tape_events import TapeEvent

_MOST_BYTES: Final = 256_000_000
"""Ten minutes with a hundred viewers take a tenth of this when decompressed."""
_MOST_EVENTS: Final = 1_000_000
_MOST_RECORD_BYTES: Final = 64_000_000
_LATEST_NS: Final = 2**63 - 1
_TOO_MUCH: Final = (
    "{path}: has {what}; a part of a tape has at most {most}, so this is none: give the tape's"
    " folder, or one of its parts"
)
_CUT: Final = "The events are cut off after {s:.1f} s: the server was killed, or the file damaged."
_ONE_ODD: Final = "One event is not as this version of WAX knows it, and is left out."
_ODD: Final = "{count} events are not as this version of WAX knows them, and are left out."
_TOPICS: Final = frozenset(map(topic, EVENTS))


@dataclass(frozen=True, slots=True)
class Events:
    """The events of a part in order of time; `problem` is a sentence, None if all were read."""

    began_wall_ms: float
    events: list[Placed]
    problem: str | None

    @property
    def began_s(self) -> float:
        """The beginning, in seconds since 1970."""
        return self.began_wall_ms / 1000

    @property
    def timed(self) -> list[tuple[float, TapeEvent]]:
        """The events with their times, in seconds since 1970."""
        return [(self.began_s + one.at_ms / 1000, one.event) for one in self.events]

    @property
    def ended_s(self) -> float:
        """The time of the newest event, in seconds since 1970."""
        return self.began_s + self.length_ms / 1000

    @property
    def length_ms(self) -> float:
        """The time of the newest event after the beginning."""
        return self.events[-1].at_ms if self.events else 0.0


def read_events(path: Path) -> Events:
    """Read a file of events; raises `StateError` with a sentence if it is no tape of ours."""
    try:
        _check_size(path, path.stat().st_size)
        with path.open("rb") as file:
            return _read(path, _Records(path, file))
    except OSError as error:
        raise StateError(f"{path}: cannot be read: {reason_of(error)}") from error


def _read(path: Path, records: _Records) -> Events:
    origin_ns: int | None = None
    channels: dict[int, str] = {}
    found: list[Placed] = []
    odd = 0
    for record in records:
        if isinstance(record, Metadata) and record.name == METADATA and origin_ns is None:
            origin_ns = _origin_ns(path, record.metadata)
        elif isinstance(record, Channel):
            channels[record.id] = record.topic
        elif isinstance(record, Message) and channels.get(record.channel_id) in _TOPICS:
            if origin_ns is None:
                break
            try:
                event = parse_event(record.data)
            except ProtocolError:
                odd += 1
                continue
            found.append(Placed(at_ms=(record.log_time - origin_ns) / 1e6, event=event))
            if len(found) > _MOST_EVENTS:
                more = f"more than {_MOST_EVENTS} events"
                raise StateError(_TOO_MUCH.format(path=path, what=more, most="so many"))
    if origin_ns is None:
        raise StateError(f"{path}: is no tape of WAX; `wax tape list` shows what there is")
    found.sort(key=lambda one: one.at_ms)
    problem = None if not odd else _ONE_ODD if odd == 1 else _ODD.format(count=odd)
    if not records.is_whole:
        problem = _CUT.format(s=found[-1].at_ms / 1000 if found else 0.0)
    return Events(origin_ns / 1e6, found, problem)


class _Records:
    """Iterates over the records up to the end or to the first unreadable one.

    Raises `StateError` for records that are too large to be ours.
    """

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        self.is_whole = False
        self._path = path
        self._reader = StreamReader(file, emit_chunks=True, record_size_limit=_MOST_RECORD_BYTES)
        self._unpacked_bytes = 0

    def __iter__(self) -> Iterator[McapRecord]:
        was_cut = False
        try:
            for record in self._reader.records:
                was_cut = was_cut or (isinstance(record, Metadata) and record.name == CUT)
                self.is_whole = isinstance(record, Footer) and not was_cut
                if isinstance(record, Chunk):
                    yield from self._unpacked(record)
                else:
                    yield record
        except StateError:
            raise
        except Exception:  # damaged bytes make the library and its codecs raise anything
            self.is_whole = False

    def _unpacked(self, chunk: Chunk) -> Sequence[McapRecord]:
        self._unpacked_bytes += _packed_bytes(chunk)
        _check_size(self._path, self._unpacked_bytes)
        return unpack(chunk)


def unpack(chunk: Chunk) -> Sequence[McapRecord]:
    """Decompress a chunk that this package wrote; raises any exception for another one."""
    if _packed_bytes(chunk) > _MOST_BYTES:
        raise ValueError
    return breakup_chunk(chunk, validate_crc=True)


def _packed_bytes(chunk: Chunk) -> int:
    size = zstandard.frame_content_size(chunk.data)
    if chunk.compression != "zstd" or size != chunk.uncompressed_size:
        raise ValueError
    return size


def _check_size(path: Path, size: int) -> None:
    if size > _MOST_BYTES:
        what, most = f"{size / 1e9:.1f} GB of events", f"{_MOST_BYTES / 1e9:g}"
        raise StateError(_TOO_MUCH.format(path=path, what=what, most=most))


def _origin_ns(path: Path, metadata: dict[str, str]) -> int:
    damaged = f"{path}: its beginning is damaged, so it cannot be read"
    try:
        version, origin_ns = int(metadata[VERSION]), int(metadata[ORIGIN])
    except (KeyError, ValueError) as error:
        raise StateError(damaged) from error
    if not 0 <= origin_ns <= _LATEST_NS:
        raise StateError(damaged)
    if version > FORMAT:
        raise StateError(
            f"{path}: was recorded by a newer WAX (format {version}, this one reads {FORMAT});"
            " update WAX to replay it"
        )
    return origin_ns
