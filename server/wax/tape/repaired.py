"""Copies media files that were cut off into finished ones, in which a browser can seek.

Nothing is decoded or encoded: the same packets are written to the new file.
"""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import av

from wax import state_dir
from wax.errors import StateError, is_disk_full, reason_of
from wax.tape.boxes import is_believable
from wax.tape.shelf import unfinished_path

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from av.container.input import InputContainer
    from av.container.output import OutputContainer
    from av.stream import Stream

_MOST_BYTES: Final = 4_000_000_000
"""More than ten minutes of the best rendition that can be configured."""
_END_US: Final = 1_000_000
_LAST_US: Final = 200_000
"""The last packet of a finished file is at most this far from its end."""
_MOST_TORN_BYTES: Final = 1_000_000
"""A second of 8 Mbit/s. A file whose unreadable end is longer is damaged, not cut off."""
_UNREADABLE: Final = "Picture and sound are damaged: {why}."
_NO_ROOM: Final = (
    "{path}: its writing was cut off, and there is no room in {folder} for a copy that can be"
    " played; free some, or name another folder with TMPDIR"
)


@dataclass(frozen=True, slots=True)
class MediaFacts:
    """A media file's contents; if unknown, `length_ms` is 0 and `problem` a sentence."""

    length_ms: float
    has_picture: bool
    has_sound: bool
    problem: str | None = None


def facts_of(path: Path) -> MediaFacts:
    """Return a file's contents, as declared at its beginning and end.

    Raises `StateError` for a file that is too large to be a part of a tape.
    """
    try:
        _check(path)
        with av.open(str(path), "r") as media:
            return MediaFacts(
                length_ms=0.0 if media.duration is None else media.duration / 1000,
                has_picture=bool(media.streams.video),
                has_sound=bool(media.streams.audio),
            )
    except (av.FFmpegError, OSError, ValueError) as error:
        return MediaFacts(0.0, False, False, _UNREADABLE.format(why=reason_of(error).lower()))


def repaired(path: Path, folder: Path) -> Path:
    """Return the file itself if it is finished, else a repaired copy in `folder`, made once.

    Raises `StateError`.
    """
    copy = folder / path.name
    if copy.exists():
        return copy
    try:
        _check(path)
        if _is_finished(path):
            return path
        new = unfinished_path(copy)
        _finish(path, new)
        new.rename(copy)
    except (av.FFmpegError, OSError, ValueError) as error:
        if is_disk_full(error):
            raise StateError(_NO_ROOM.format(path=path, folder=folder.parent)) from error
        raise StateError(f"{path}: {_UNREADABLE.format(why=reason_of(error).lower())}") from error
    return copy


def finish_media(path: Path, is_there: Callable[[], bool]) -> None:
    """Replace a file that was cut off by a finished copy.

    `is_there` returns whether its part still exists. Raises `StateError`, or `OSError` if the disk
    has no room for the copy; in both cases the file stays as it was.
    """
    new = unfinished_path(path)
    try:
        _check(path)
        if _is_finished(path):
            return
        status = path.stat()
        state_dir.make_private(new)
        if status.st_size - _finish(path, new) > _MOST_TORN_BYTES:
            raise StateError(f"{path}: {_UNREADABLE.format(why='they end too soon')}")
        os.utime(new, ns=(status.st_atime_ns, status.st_mtime_ns))
        state_dir.sync(new)
        new.replace(path)
        if not is_there():
            path.unlink(missing_ok=True)
    except (av.FFmpegError, OSError, ValueError) as error:
        if is_disk_full(error):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error
        raise StateError(f"{path}: {_UNREADABLE.format(why=reason_of(error).lower())}") from error
    finally:
        new.unlink(missing_ok=True)


def _finish(path: Path, new: Path) -> int:
    """Copy a file and finish the copy; return the end of the readable bytes."""
    with (
        av.open(str(path), "r") as media,
        av.open(str(new), "w", format=_format(media)) as output,
    ):
        return _copy(media, output)


def _check(path: Path) -> None:
    """Refuse a file that would take minutes to scan; raises what its callers handle."""
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise StateError(
            f"{path}: has {size / 1e9:.0f} GB of picture and sound; a part of a tape has at most"
            f" {_MOST_BYTES / 1e9:g}, so this is none: give the tape's folder, or one of its parts"
        )
    if not is_believable(path):
        raise ValueError("it counts more samples than it could hold")


def _is_finished(path: Path) -> bool:
    """Return whether the file is as long as its header, which is completed last, declares.

    Fragmented MP4 never declares its length.
    """
    with av.open(str(path), "r") as media:
        if media.duration is None or "matroska" not in media.format.name:
            return False
        try:
            media.seek(max(0, media.duration - _END_US))
            ends = [float(one.pts * one.time_base) for one in media.demux() if one.pts is not None]
        except av.FFmpegError:
            return False
        return bool(ends) and max(ends) * 1e6 >= media.duration - _LAST_US


def _format(media: InputContainer) -> str:
    return "webm" if "matroska" in media.format.name else "mp4"


def _copy(media: InputContainer, output: OutputContainer) -> int:
    """Copy all readable packets; return the byte at which the last of them ends."""
    end = 0
    copies: dict[int, Stream] = {
        stream.index: output.add_stream_from_template(stream, opaque=True)
        for stream in (*media.streams.video, *media.streams.audio)
    }
    try:
        for packet in media.demux():
            # An empty packet marks the end of its stream.
            if packet.dts is not None and packet.size and packet.stream_index in copies:
                end = max(end, (packet.pos or 0) + packet.size)
                packet.stream = copies[packet.stream_index]
                output.mux(packet)
    except (av.error.InvalidDataError, av.error.EOFError):
        pass
    return end
