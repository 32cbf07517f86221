"""Writes the picture and sound of one part to a file without re-encoding them.

VP8 goes into WebM, H.264 into fragmented MP4. Both are written in pieces of half a second that are
playable without the following ones, so that a killed server loses no more than one.
"""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, Final, Literal

import av

from wax import state_dir
from wax.capture.source import SAMPLE_RATE_HZ
from wax.encode.encoded import VIDEO_RATE_HZ, VIDEO_TIME_BASE

if TYPE_CHECKING:
    from pathlib import Path

    from av.container.output import OutputContainer
    from av.stream import Stream

    from wax.encode.encoded import EncodedPicture, EncodedSound

Codec = Literal["vp8", "h264"]

ENDINGS: Final[dict[Codec, str]] = {"vp8": ".webm", "h264": ".mp4"}

_PIECE_MS: Final = 500
_COMMON: Final = {
    "flush_packets": "1",
    # A stream that has ended, as when a microphone is unplugged, delays the other by this at most.
    "max_interleave_delta": "200000",
}
_OPTIONS: Final[dict[Codec, dict[str, str]]] = {
    "vp8": {"cluster_time_limit": str(_PIECE_MS)},
    "h264": {
        "movflags": "frag_keyframe+empty_moov+default_base_moof",
        "frag_duration": str(_PIECE_MS * 1000),
    },
}
_FORMATS: Final[dict[Codec, str]] = {"vp8": "webm", "h264": "mp4"}
_SOUND_TIME_BASE: Final = Fraction(1, SAMPLE_RATE_HZ)
_GAP_S: Final = 0.04
"""Sound whose capture time is further from its counted position follows a gap."""


class TapeFile:
    """A file that begins at `origin_s` on the server's clock; without a `size` it has no pictures.

    With two `sound_channels` packets may have one or two: players play both as stereo (RFC 7845,
    5.1).

    Not thread-safe. All methods may raise `OSError` or `av.FFmpegError`.
    """

    def __init__(
        self,
        path: Path,
        *,
        codec: Codec,
        size: tuple[int, int] | None,
        has_sound: bool,
        origin_s: float,
        sound_channels: int = 1,
    ) -> None:
        state_dir.make_private(path)
        self._path = path
        self._origin_s = origin_s
        self._container: OutputContainer = av.open(
            str(path), "w", format=_FORMATS[codec], container_options=_COMMON | _OPTIONS[codec]
        )
        self._picture: Stream | None = None
        if size is not None:
            width, height = size
            self._picture = self._container.add_mux_stream(
                codec, width=width, height=height, time_base=VIDEO_TIME_BASE
            )
        self._sound: Stream | None = None
        if has_sound:
            # The encoder encodes nothing: it only supplies the Opus header that the muxer needs.
            self._sound = self._container.add_stream(
                "libopus",
                rate=SAMPLE_RATE_HZ,
                layout="mono" if sound_channels == 1 else "stereo",
                options={"application": "lowdelay"},
            )
        self._newest = {"picture": -1, "sound": -1}
        self._sound_shift: int | None = None

    def picture(self, picture: EncodedPicture) -> None:
        """Add a picture; the first must be a keyframe."""
        if self._picture is None:
            return
        pts = round((picture.captured_s - self._origin_s) * VIDEO_RATE_HZ)
        if not self._is_next("picture", pts):
            return
        packet = av.Packet(picture.data)
        packet.pts = packet.dts = pts
        packet.time_base = VIDEO_TIME_BASE
        packet.is_keyframe = picture.keyframe
        packet.stream = self._picture
        self._container.mux_one(packet)

    def sound(self, sound: EncodedSound) -> None:
        """Add an Opus packet, if it was captured since the beginning of the file.

        Its position is counted in samples, which leaves no gaps, and moves by one sample a packet
        towards the capture time, because the sound card's clock drifts from the picture's.
        """
        if self._sound is None:
            return
        captured = round((sound.captured_s - self._origin_s) * SAMPLE_RATE_HZ)
        away = 0 if self._sound_shift is None else captured - sound.pts - self._sound_shift
        if self._sound_shift is None or abs(away) > _GAP_S * SAMPLE_RATE_HZ:
            self._sound_shift = captured - sound.pts
        else:
            self._sound_shift += max(-1, min(1, away))
        pts = sound.pts + self._sound_shift
        if pts < 0 or not self._is_next("sound", pts):
            return
        packet = av.Packet(sound.data)
        packet.pts = packet.dts = pts
        packet.duration = sound.duration_samples
        packet.time_base = _SOUND_TIME_BASE
        packet.is_keyframe = True
        packet.stream = self._sound
        self._container.mux_one(packet)

    def sync(self) -> None:
        """Sync to disk, so that a power cut loses only the newest piece."""
        with suppress(FileNotFoundError):  # deleted meanwhile
            state_dir.sync(self._path)

    def close(self) -> None:
        """Finish the file, which makes it quick to seek in."""
        self._container.close()
        self.sync()

    def _is_next(self, stream: str, pts: int) -> bool:
        """Return whether `pts` is later than the last one; the muxers reject others."""
        if pts <= self._newest[stream]:
            return False
        self._newest[stream] = pts
        return True
