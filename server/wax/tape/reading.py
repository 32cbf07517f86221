"""Reads the events of one part, whole or cut: what is readable counts, the rest is said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mcap.records import Channel, Footer, Message, Metadata
from mcap.stream_reader import StreamReader

from wax.errors import ProtocolError, StateError
from wax.protocol.tape_events import EVENTS, FORMAT, Placed, parse_event, topic
from wax.tape.event_file import METADATA, ORIGIN, VERSION

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mcap.records import McapRecord

_MOST_BYTES: Final = 256_000_000
"""Ten minutes with a hundred viewers take a tenth of it."""
_MOST_RECORD_BYTES: Final = 64_000_000
_CUT: Final = "The events are cut off after {s:.1f} s: the server was killed, or the file damaged."
_ODD: Final = "{count} events are not as this version of WAX knows them, and are left out."
_TOPICS: Final = frozenset(map(topic, EVENTS))


@dataclass(frozen=True, slots=True)
class Events:
    """The events of a part in their order; `problem` is a sentence, None if all were read."""

    began_wall_ms: float
    events: list[Placed]
    problem: str | None

    @property
    def length_ms(self) -> float:
        """How long after the beginning the newest event was."""
        return self.events[-1].at_ms if self.events else 0.0


def read_events(path: Path) -> Events:
    """Read a file of events; raises `StateError` with one sentence for what is no tape of ours."""
    try:
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise StateError(
                f"{path}: has {size / 1e9:.1f} GB of events; a part of a tape has at most"
                f" {_MOST_BYTES / 1e9:g}, so this is none: give the tape's folder, or one of its"
                " parts"
            )
        with path.open("rb") as file:
            return _read(path, StreamReader(file, record_size_limit=_MOST_RECORD_BYTES))
    except OSError as error:
        raise StateError(f"{path}: cannot be read: {error.strerror or error}") from error


def _read(path: Path, reader: StreamReader) -> Events:
    origin_ns: int | None = None
    channels: dict[int, str] = {}
    found: list[Placed] = []
    odd = 0
    records = _Records(reader)
    for record in records:
        if isinstance(record, Metadata) and record.name == METADATA:
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
    if origin_ns is None:
        raise StateError(f"{path}: is no tape of WAX; `wax tape list` shows what there is")
    found.sort(key=lambda one: one.at_ms)
    problem = _ODD.format(count=odd) if odd else None
    if not records.is_whole:
        problem = _CUT.format(s=found[-1].at_ms / 1000 if found else 0.0)
    return Events(origin_ns / 1e6, found, problem)


class _Records:
    """The records up to the end, or to where they can be read no further."""

    def __init__(self, reader: StreamReader) -> None:
        self._reader = reader
        self.is_whole = False

    def __iter__(self) -> Iterator[McapRecord]:
        try:
            for record in self._reader.records:
                self.is_whole = isinstance(record, Footer)
                yield record
        except Exception:  # of damaged bytes the library and its codecs raise all kinds
            self.is_whole = False


def _origin_ns(path: Path, metadata: dict[str, str]) -> int:
    try:
        version, origin_ns = int(metadata[VERSION]), int(metadata[ORIGIN])
    except (KeyError, ValueError) as error:
        raise StateError(f"{path}: its beginning is damaged, so it cannot be read") from error
    if version > FORMAT:
        raise StateError(
            f"{path}: was recorded by a newer WAX (format {version}, this one reads {FORMAT});"
            " update WAX to replay it"
        )
    return origin_ns
