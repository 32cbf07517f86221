"""Open a media file or stream address, or explain in a sentence why that failed."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal
from urllib.parse import urlsplit

import av
from av.error import (
    FFmpegError,
    HTTPForbiddenError,
    HTTPNotFoundError,
    HTTPUnauthorizedError,
    InvalidDataError,
)
from av.stream import Disposition

from wax.capture.file.not_opened import not_opened
from wax.capture.stream_dating import Dating
from wax.errors import SourceError, reason_of
from wax.logs.printable import shown_url
from wax.sentence import Sentence
from wax.unreachable import Target

if TYPE_CHECKING:
    from av.audio.codeccontext import AudioCodecContext
    from av.container import InputContainer
    from av.video.codeccontext import VideoCodecContext

Kind = Literal["video", "audio"]

_TIMEOUT_S: Final = (5.0, 2.0)
"""Timeouts for connecting, and between packets: a stream that pauses for longer is reopened."""

Transport = Literal["auto", "tcp", "udp"]

_HTTP: Final = frozenset({"http", "https"})
_NO_MULTIPART: Final = frozenset(
    {
        *(".jpg", ".jpeg", ".png", ".m3u8", ".mpd"),
        *(".mp4", ".m4v", ".mov", ".ts", ".mkv", ".webm", ".flv", ".avi"),
        *(".mp3", ".aac", ".ogg", ".opus", ".wav", ".flac"),
    }
)
"""Suffixes that rule out multipart JPEG, so that no second request is needed."""

_RTSP: Final = frozenset({"rtsp", "rtsps"})
_TRANSPORT: Final[dict[Transport, dict[str, str]]] = {
    # Over UDP lost packets of keyframes cost pictures; TCP costs one round trip.
    "auto": {"rtsp_flags": "prefer_tcp"},
    "tcp": {"rtsp_transport": "tcp"},
    # Reordering waits for a packet only so long that people do not notice.
    "udp": {"rtsp_transport": "udp", "max_delay": "50000"},
}
_LOW_DELAY: Final = {"fflags": "nobuffer", "flags": "low_delay", "analyzeduration": "1000000"}
"""FFmpeg buffers nothing, and probes a stream for at most a second before showing it."""

_BARE_JPEG: Final = {"fpsprobesize": "0", "analyzeduration": "100000"}

_LIVE_SCHEMES: Final = frozenset({"rtsp", "rtsps", "rtp", "rtmp", "rtmps", "udp", "srt", "tcp"})
_DATAGRAMS: Final = frozenset({"udp", "rtp"})
_UNBOUNDED: Final = frozenset({"mpegts", "mpeg"})
"""Containers whose video packets do not declare their length (ISO/IEC 13818-1, 2.4.3.7)."""

_SEGMENTED: Final = frozenset({"hls", "dash"})
_ONE_PICTURE: Final = ("image2", "_pipe")
"""Demuxers of single pictures: each request may return an old one."""

_NO_TIMESTAMPS: Final = 0x80
_GENERIC_INDEX: Final = 0x100
"""Flags of FFmpeg's demuxers (libavformat/avformat.h): FFmpeg makes up the stamps; the stream is
bare, so that a parser must find where a picture ends."""

_DEFAULT_PERIOD_S: Final = {"video": 0.04, "audio": 0.02}


class RefusedError(SourceError):
    """The user name or the password is wrong or missing."""


@dataclass(slots=True)
class Track:
    """One decodable stream of an open container.

    `pixel_aspect` is a pixel's width divided by its height, `period_s` the length of packets that
    do not specify it.
    """

    index: int
    kind: Kind
    decoder: VideoCodecContext | AudioCodecContext
    pixel_aspect: float
    period_s: float


def is_network(address: str) -> bool:
    """Return whether the address is ``scheme://…``, not a path."""
    return "://" in address


def shown_name(address: str) -> str:
    """Return the address without user name, password and query, to show to anyone."""
    return shown_url(address) if is_network(address) else Path(address).name


def is_rtsp(address: str) -> bool:
    """Return whether the address is an RTSP stream's."""
    return urlsplit(address).scheme in _RTSP


def open_container(address: str, transport: Transport = "auto") -> InputContainer:
    """Open for reading; raises `SourceError`, for a network address after at most 5 s.

    FFmpeg's errors contain the whole address with its password, so they are never passed on.
    """
    name = shown_name(address)
    began_s = time.monotonic()
    try:
        if is_rtsp(address):
            options = _TRANSPORT[transport] | _LOW_DELAY
            return av.open(address, timeout=_TIMEOUT_S, options=options)
        if is_network(address):
            return _open_http(address) or av.open(address, timeout=_TIMEOUT_S)
        return av.open(f"file:{address}")
    except FileNotFoundError:
        raise SourceError(Sentence("file.missing", {"name": name})) from None
    except (HTTPUnauthorizedError, HTTPForbiddenError):
        raise RefusedError(Sentence("file.refused", {"name": name})) from None
    except HTTPNotFoundError:
        raise SourceError(Sentence("file.not_there", {"name": name})) from None
    except (FFmpegError, OSError) as error:
        raise SourceError(_why(name, address, error, time.monotonic() - began_s)) from None


def _why(name: str, address: str, error: Exception, took_s: float) -> Sentence:
    # With RTSP, FFmpeg reports an answer that never came as invalid data, too.
    if isinstance(error, InvalidDataError) and not is_rtsp(address):
        return Sentence("file.unplayable", {"name": name})
    if not is_network(address):
        return Sentence("file.not_open", {"name": name, "why": reason_of(error)})
    target = Target.of(address, _TIMEOUT_S[0])
    return not_opened(name, target, error, is_late=took_s >= _TIMEOUT_S[0])


def _open_http(address: str) -> InputContainer | None:
    """Open an HTTP address that may be a network camera's JPEG; return None for any other address.

    Left to itself, FFmpeg detects most multipart JPEG as bare JPEG: it probes for 5 s, and returns
    each picture only when the next one has begun. Without a first boundary it detects nothing.
    """
    parts = urlsplit(address)
    if parts.scheme not in _HTTP or Path(parts.path).suffix.lower() in _NO_MULTIPART:
        return None
    with suppress(InvalidDataError, EOFError):
        return av.open(address, timeout=_TIMEOUT_S, format="mpjpeg")
    try:
        return av.open(address, timeout=_TIMEOUT_S)
    except InvalidDataError:
        found = av.open(address, timeout=_TIMEOUT_S, format="mjpeg", options=_BARE_JPEG)
        if found.streams.video[0].width:
            return found
        found.close()
        raise


def is_live(address: str, container: InputContainer) -> bool:
    """Return whether the remote end sets the pace, so that nothing may be queued here."""
    if not is_network(address):
        return False
    if urlsplit(address).scheme in _LIVE_SCHEMES:
        return True
    if is_one_picture(container):
        return False
    endless = container.duration is None and container.size <= 0  # no Content-Length
    return endless and container.format.name not in _SEGMENTED


def is_one_picture(container: InputContainer) -> bool:
    """Return whether the address is a still picture, such as a camera's snapshot."""
    return container.format.name.endswith(_ONE_PICTURE)


def has_own_clock(address: str, container: InputContainer) -> bool:
    """Return whether a paced address is a demonstration, that is, a film stored on this machine.

    It is played by our clock, so it counts as captured when it is shown. Everything else was stored
    elsewhere for an unknown time: segments, a film over HTTP, and a snapshot, even one in a local
    file, because another program may overwrite it.
    """
    segmented = container.format.name in _SEGMENTED
    return not (is_network(address) or segmented or is_one_picture(container))


def live_dating(address: str, container: InputContainer, transport: Transport) -> Dating:
    """Build the dating of a live stream's packets."""
    return Dating(
        stamped=not int(container.format.flags) & _NO_TIMESTAMPS,
        queues=urlsplit(address).scheme not in _DATAGRAMS
        and not (is_rtsp(address) and transport == "udp"),
    )


def ends_with_next(container: InputContainer) -> bool:
    """Return whether the demuxer returns a picture only once the next one has begun."""
    kind = container.format
    is_bare = int(kind.flags) & _NO_TIMESTAMPS and int(kind.flags) & _GENERIC_INDEX
    return bool(is_bare) or kind.name in _UNBOUNDED


def find_tracks(container: InputContainer) -> dict[Kind, Track]:
    """Return the first decodable video and audio streams; cover pictures do not count."""
    tracks: dict[Kind, Track] = {}
    for stream in container.streams.video:
        if "video" in tracks or stream.disposition & Disposition.attached_pic:
            continue
        if stream.codec_context is not None:
            rate = stream.average_rate or stream.guessed_rate
            tracks["video"] = Track(
                index=stream.index,
                kind="video",
                decoder=stream.codec_context,
                pixel_aspect=float(stream.sample_aspect_ratio or 1),
                period_s=float(1 / rate) if rate else _DEFAULT_PERIOD_S["video"],
            )
    for sound in container.streams.audio:
        if "audio" not in tracks and sound.codec_context is not None:
            tracks["audio"] = Track(
                index=sound.index,
                kind="audio",
                decoder=sound.codec_context,
                pixel_aspect=1.0,
                period_s=_DEFAULT_PERIOD_S["audio"],
            )
    return tracks
