"""Reads the pictures of one camera from the parts of a tape, in order of capture."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import av

from wax.errors import StateError, reason_of
from wax.tape.repaired import facts_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from av.container.input import InputContainer
    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

_US: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class PictureFile:
    """A file of pictures whose time 0 is `origin_s` since 1970."""

    path: Path
    origin_s: float
    codec: str
    size: tuple[int, int]
    header: bytes | None


def picture_file(path: Path, origin_s: float) -> PictureFile | None:
    """Return what a file shows, None if it has no picture; raises `StateError` if it is damaged."""
    problem = facts_of(path).problem
    try:
        if problem is None:
            with av.open(str(path), "r") as media:
                if not media.streams.video:
                    return None
                stream = media.streams.video[0]
                context = stream.codec_context
                size = stream.width, stream.height
                return PictureFile(path, origin_s, context.name, size, context.extradata)
    except (av.FFmpegError, OSError) as error:
        problem = reason_of(error)
    raise StateError(f"{path.name}: {problem}")


def packets(
    file: PictureFile, begin_s: float, end_s: float
) -> Iterator[tuple[float, Packet[VideoStream]]]:
    """Yield packets with their capture times, from the keyframe before `begin_s` until `end_s`.

    A file that was cut off ends with its last whole packet. Raises `OSError` or `av.FFmpegError`.
    """
    with av.open(str(file.path), "r") as media:
        _seek(media, begin_s - file.origin_s)
        with suppress(av.error.InvalidDataError, av.error.EOFError):
            for packet in media.demux(media.streams.video[0]):
                if packet.pts is None or not packet.size:
                    continue
                captured_s = file.origin_s + float(packet.pts * packet.time_base)
                if captured_s >= end_s:
                    return
                yield captured_s, packet


def decoded(
    files: Sequence[PictureFile], begin_s: float, end_s: float, tell: Callable[[str], None]
) -> Iterator[tuple[float, VideoFrame]]:
    """Yield the pictures captured from `begin_s` until `end_s`; `tell` hears what is damaged."""
    for file in files:
        try:
            for _, packet in packets(file, begin_s, end_s):
                for frame in packet.decode():
                    if not isinstance(frame, av.VideoFrame) or frame.time is None:
                        continue
                    if (captured_s := file.origin_s + frame.time) >= begin_s:
                        yield captured_s, frame
        except (av.FFmpegError, OSError) as error:
            tell(f"{file.path.name}: its pictures cannot be read: {reason_of(error)}")


def _seek(media: InputContainer, at_s: float) -> None:
    """Go to the keyframe before `at_s`, or to the beginning where the file has no index."""
    if at_s > 0:
        with suppress(av.FFmpegError):
            media.seek(int(at_s * _US))
