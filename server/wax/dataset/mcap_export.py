"""`wax tape export --mcap`: one MCAP file of a time span, which other viewers show without plug-in.

Beside the events it has picture, place, and what the gate decided in well-known schemas. A picture
in H.264 is copied; VP8 is in no well-known schema, so it becomes JPEG.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

import av
import cv2
from av.bitstream import BitStreamFilterContext
from mcap.writer import CompressionType, Writer

from wax import __version__
from wax.capture.source import SAMPLE_RATE_HZ
from wax.dataset.foxglove import (
    AUDIO,
    IMAGE,
    LOG,
    POSE,
    VIDEO,
    LogLines,
    message_of,
    pose_of,
    stamp,
    values_of,
)
from wax.dataset.parts import cameras_of, cannot_write, events_of, pictures_of
from wax.dataset.pictures import PictureFile, decoded, packets
from wax.dataset.protobuf import encode, schema_of
from wax.errors import StateError, reason_of
from wax.protocol.tape_events import Named, topic

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from wax.dataset.protobuf import MessageType
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.selection import Selection
    from wax.tape.shelf import Shelved

_QUALITY: Final = 80
_JPEG: Final = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]


@dataclass(frozen=True, slots=True)
class _Item:
    """A message on its topic, at a time in nanoseconds since 1970."""

    at_ns: int
    topic: str
    message: MessageType
    values: dict[str, Any]


def export_mcap(
    selection: Selection,
    path: Path,
    *,
    jpeg: bool = False,
    sound: bool = False,
    tell: Callable[[str], None],
) -> str:
    """Write the file, and return what to print; `tell` hears the progress.

    `jpeg` makes H.264 to JPEG, too. Raises `StateError` with what to do.
    """
    if path.exists():
        raise StateError(f"{path}: is there already; name another file, or delete it")
    partial = path.with_name(f"{path.name}.partial")
    try:
        exported = _Export(selection, jpeg=jpeg, sound=sound)
        partial.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("wb") as file:
            writer = Writer(file, compression=CompressionType.ZSTD)
            writer.start(profile="", library=f"wax {__version__}")
            count = exported.write(writer, tell)
            writer.finish()  # type: ignore[no-untyped-call]  # the library has no annotation
        left_out = [f"  left out: {one}" for one in exported.left_out]
        if not count:
            raise StateError("\n".join(["there is nothing to export at that time", *left_out]))
        partial.rename(path)
    except OSError as error:
        raise cannot_write(path, error) from error
    finally:
        partial.unlink(missing_ok=True)
    lines = [f"{path}: {count} messages, {path.stat().st_size / 1e6:.1f} MB"]
    return "\n".join([*lines, *left_out])


class _Export:
    """What is written, part by part."""

    def __init__(self, selection: Selection, *, jpeg: bool, sound: bool) -> None:
        self._selection = selection
        self._jpeg = jpeg
        self._sound = sound
        self._log = LogLines()
        self._channels: dict[str, int] = {}
        self._part: Shelved
        self.left_out: list[str] = []

    def write(self, writer: Writer, tell: Callable[[str], None]) -> int:
        """Write all parts; return how many messages there are."""
        count = 0
        parts = self._selection.parts
        for number, part in enumerate(parts, start=1):
            self._part = part
            try:
                count += self._write_part(writer, part)
            except StateError as error:
                self.left_out.append(str(error))
            except ValueError as error:  # a number that is too large
                self.left_out.append(f"{part.name}: {error}")
            tell(f"{number} of {len(parts)}: {part.name}")
        return count

    def _write_part(self, writer: Writer, part: Shelved) -> int:
        events = events_of(part)
        if events.problem is not None:
            self.left_out.append(f"{part.name}: {events.problem}")
        streams = [self._events(events.timed)]
        for name, (path, began_s) in cameras_of(part, events).items():
            try:
                streams.append(self._pictures(name, pictures_of(part, name, path, began_s)))
            except StateError as error:
                self.left_out.append(str(error))
        if self._sound and part.media is not None:
            streams.append(self._sounds(part.media, events.began_s))
        count = 0
        for item in heapq.merge(*streams, key=attrgetter("at_ns")):
            if self._has(item.at_ns / 1e9):
                self._write(writer, item)
                count += 1
        return count

    def _has(self, at_s: float) -> bool:
        """Whether this time is to be exported."""
        chosen = self._selection
        return chosen.begin_s <= at_s < chosen.end_s and not self._part.is_disowned(at_s)

    def _write(self, writer: Writer, item: _Item) -> None:
        channel = self._channels.get(item.topic)
        if channel is None:
            kind = item.message
            schema = writer.register_schema(kind.full_name, "protobuf", schema_of(kind))
            channel = self._channels[item.topic] = writer.register_channel(
                item.topic, "protobuf", schema
            )
        data = encode(item.message, item.values | {"timestamp": stamp(item.at_ns)})
        writer.add_message(channel, log_time=item.at_ns, publish_time=item.at_ns, data=data)

    def _events(self, events: list[tuple[float, TapeEvent]]) -> Iterator[_Item]:
        for at_s, event in events:
            if isinstance(event, Named):
                continue
            at_ns = round(at_s * 1e9)
            yield _Item(at_ns, topic(type(event)), message_of(type(event)), values_of(event))
            if (pose := pose_of(event)) is not None:
                yield _Item(at_ns, "/pose", POSE, pose)
            if self._has(at_s) and (line := self._log.line_of(event)) is not None:
                yield _Item(at_ns, "/log", LOG, line)

    def _pictures(self, name: str, file: PictureFile) -> Iterator[_Item]:
        begin_s, end_s = self._selection.begin_s, self._selection.end_s
        copies = file.codec == "h264" and not self._jpeg
        made = self._copied(file) if copies else self._encoded(file, begin_s, end_s)
        for captured_s, data in made:
            values = {"frame_id": name, "format": "h264" if copies else "jpeg", "data": data}
            message = VIDEO if copies else IMAGE
            yield _Item(round(captured_s * 1e9), f"/camera/{name}", message, values)

    def _copied(self, file: PictureFile) -> Iterator[tuple[float, bytes]]:
        """Yield pictures as a byte stream (H.264, annex B); after what is left out, a keyframe."""
        convert: BitStreamFilterContext | None = None
        waits = True
        try:
            for captured_s, packet in packets(file, self._selection.begin_s, self._selection.end_s):
                if convert is None:
                    convert = BitStreamFilterContext("h264_mp4toannexb", packet.stream)
                waits = not self._has(captured_s) or (waits and not packet.is_keyframe)
                for converted in convert.filter(packet):
                    if not waits:
                        yield captured_s, bytes(converted)
        except (av.FFmpegError, OSError) as error:
            self._cannot_read(file.path, "pictures", error)

    def _encoded(
        self, file: PictureFile, begin_s: float, end_s: float
    ) -> Iterator[tuple[float, bytes]]:
        for captured_s, picture in decoded([file], begin_s, end_s, self.left_out.append):
            if self._has(captured_s):
                _, data = cv2.imencode(".jpg", picture.to_ndarray(format="bgr24"), _JPEG)
                yield captured_s, data.tobytes()

    def _sounds(self, path: Path, origin_s: float) -> Iterator[_Item]:
        resampler = av.AudioResampler("s16", rate=SAMPLE_RATE_HZ)
        try:
            with av.open(str(path), "r") as media:
                if not media.streams.audio:
                    return
                for frame in media.decode(media.streams.audio[0]):
                    if frame.time is None:
                        continue
                    for plain in resampler.resample(frame):
                        yield _Item(
                            round((origin_s + frame.time) * 1e9),
                            "/sound",
                            AUDIO,
                            {
                                "data": plain.to_ndarray().tobytes(),
                                "format": "pcm-s16",
                                "sample_rate": SAMPLE_RATE_HZ,
                                "number_of_channels": plain.layout.nb_channels,
                            },
                        )
        except (av.FFmpegError, OSError) as error:
            self._cannot_read(path, "sound", error)

    def _cannot_read(self, path: Path, what: str, error: Exception) -> None:
        self.left_out.append(f"{path.name}: its {what} cannot be read: {reason_of(error)}")
