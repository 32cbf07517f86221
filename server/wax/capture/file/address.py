"""Open a media file or stream address, or explain in a sentence why that failed."""

from __future__ import annotations

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

from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from av.audio.codeccontext import AudioCodecContext
    from av.container import InputContainer
    from av.video.codeccontext import VideoCodecContext

Kind = Literal["video", "audio"]

_TIMEOUT_S: Final = (5.0, 2.0)
"""For connecting, and between packets: a stream that pauses for longer is opened again."""

Transport = Literal["auto", "tcp", "udp"]

_RTSP: Final = frozenset({"rtsp", "rtsps"})
_TRANSPORT: Final[dict[Transport, dict[str, str]]] = {
    # UDP loses packets of keyframes, and with them pictures; TCP costs one round trip.
    "auto": {"rtsp_flags": "prefer_tcp"},
    "tcp": {"rtsp_transport": "tcp"},
    # A packet out of order is waited for as long as people do not notice.
    "udp": {"rtsp_transport": "udp", "max_delay": "50000"},
}
_AT_ONCE: Final = {"fflags": "nobuffer", "flags": "low_delay", "analyzeduration": "1000000"}
"""Nothing is kept back, and a stream is looked at for at most a second before it is shown."""

_LIVE_SCHEMES: Final = frozenset({"rtsp", "rtsps", "rtp", "rtmp", "rtmps", "udp", "srt", "tcp"})
_SEGMENTED: Final = frozenset({"hls", "dash"})
_DEFAULT_PERIOD_S: Final = {"video": 0.04, "audio": 0.02}


class RefusedError(SourceError):
    """The user name or the password is wrong, or missing."""


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
    """Whether this is ``scheme://…``, not a path."""
    return "://" in address


def shown_name(address: str) -> str:
    """Return the address without user name, password and query, since everybody sees messages."""
    if not is_network(address):
        return Path(address).name
    parts = urlsplit(address)
    return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path}"


def is_rtsp(address: str) -> bool:
    """Whether it is a camera's stream by RTSP."""
    return urlsplit(address).scheme in _RTSP


def open_container(address: str, transport: Transport = "auto") -> InputContainer:
    """Open for reading; raises `SourceError`. A network address gives up after 5 s.

    FFmpeg's errors have the whole address, with its password, so none of them is passed on.
    """
    name = shown_name(address)
    try:
        if is_rtsp(address):
            options = _TRANSPORT[transport] | _AT_ONCE
            return av.open(address, timeout=_TIMEOUT_S, options=options)
        if is_network(address):
            return av.open(address, timeout=_TIMEOUT_S)
        return av.open(f"file:{address}")
    except InvalidDataError:
        # By RTSP it is also what FFmpeg calls an answer that never came.
        raise SourceError(
            Sentence("file.unreachable" if is_rtsp(address) else "file.unplayable", {"name": name})
        ) from None
    except FileNotFoundError:
        raise SourceError(Sentence("file.missing", {"name": name})) from None
    except (HTTPUnauthorizedError, HTTPForbiddenError):
        raise RefusedError(Sentence("file.refused", {"name": name})) from None
    except HTTPNotFoundError:
        raise SourceError(Sentence("file.not_there", {"name": name})) from None
    except (FFmpegError, OSError) as error:
        reason = error.strerror or type(error).__name__
        raise SourceError(Sentence("file.not_open", {"name": name, "why": reason})) from None


def is_live(address: str, container: InputContainer) -> bool:
    """Whether the remote end sets the pace, so that nothing may be queued here."""
    if not is_network(address):
        return False
    if urlsplit(address).scheme in _LIVE_SCHEMES:
        return True
    endless = container.duration is None and container.size <= 0  # no Content-Length
    return endless and container.format.name not in _SEGMENTED


def find_tracks(container: InputContainer) -> dict[Kind, Track]:
    """Return the first decodable video and audio streams, without cover pictures."""
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
