"""Picture and sound whose writing was cut off, copied so that a browser can seek in them.

Nothing is decoded or encoded: the same packets go into a file that is finished.
"""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import av

from wax import state_dir
from wax.errors import StateError, reason_of
from wax.tape.boxes import is_believable
from wax.tape.shelf import unready

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
"""The last packet of a finished file is not further from its end."""
_MOST_TORN_BYTES: Final = 1_000_000
"""A second of 8 Mbit/s. A file that cannot be read so near to its end is damaged, not cut off."""
_FULL: Final = (errno.ENOSPC, errno.EDQUOT)
_UNREADABLE: Final = "Picture and sound are damaged: {why}."
_NO_ROOM: Final = (
    "{path}: its writing was cut off, and there is no room in {folder} for a copy that can be"
    " played; free some, or name another folder with TMPDIR"
)


@dataclass(frozen=True, slots=True)
class MediaFacts:
    """What is in a media file; `length_ms` is 0 and `problem` a sentence where it is unknown."""

    length_ms: float
    has_picture: bool
    has_sound: bool
    problem: str | None = None


def facts_of(path: Path) -> MediaFacts:
    """Return what is in a file, as far as its beginning and its end say it.

    Raises `StateError` for one that is too large to be a part of a tape.
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
    """Return the file itself if it is finished, else a copy in `folder`, made once.

    Raises `StateError`.
    """
    copy = folder / path.name
    if copy.exists():
        return copy
    try:
        _check(path)
        if _is_finished(path):
            return path
        new = unready(copy)
        _finish(path, new)
        new.rename(copy)
    except (av.FFmpegError, OSError, ValueError) as error:
        if getattr(error, "errno", None) in _FULL:
            raise StateError(_NO_ROOM.format(path=path, folder=folder.parent)) from error
        raise StateError(f"{path}: {_UNREADABLE.format(why=reason_of(error).lower())}") from error
    return copy


def finish_media(path: Path, is_there: Callable[[], bool]) -> None:
    """Put a finished copy in the place of a file whose writing was cut off.

    `is_there` says whether its part was not deleted meanwhile. Raises `StateError`, and `OSError`
    where the disk cannot take the copy; the file is as it was then.
    """
    new = unready(path)
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
        if getattr(error, "errno", None) in _FULL:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error
        raise StateError(f"{path}: {_UNREADABLE.format(why=reason_of(error).lower())}") from error
    finally:
        new.unlink(missing_ok=True)


def _finish(path: Path, new: Path) -> int:
    """Copy a file and finish the copy; return up to which byte the file could be read."""
    with (
        av.open(str(path), "r") as media,
        av.open(str(new), "w", format=_format(media)) as output,
    ):
        return _copy(media, output)


def _check(path: Path) -> None:
    """Refuse at once what would take minutes to look through; raises what its callers handle."""
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise StateError(
            f"{path}: has {size / 1e9:.0f} GB of picture and sound; a part of a tape has at most"
            f" {_MOST_BYTES / 1e9:g}, so this is none: give the tape's folder, or one of its parts"
        )
    if not is_believable(path):
        raise ValueError("it counts more samples than it could hold")


def _is_finished(path: Path) -> bool:
    """Whether the file says how long it is, which is written last, and is so long.

    Fragments of MP4 never say it.
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
    """Copy all packets up to the end, or to where the file is cut; return where that is."""
    end = 0
    copies: dict[int, Stream] = {
        stream.index: output.add_stream_from_template(stream, opaque=True)
        for stream in (*media.streams.video, *media.streams.audio)
    }
    try:
        for packet in media.demux():
            # An empty one marks the end of its stream.
            if packet.dts is not None and packet.size and packet.stream_index in copies:
                end = max(end, (packet.pos or 0) + packet.size)
                packet.stream = copies[packet.stream_index]
                output.mux(packet)
    except (av.error.InvalidDataError, av.error.EOFError):
        pass
    return end
