"""One stream of a media file, decoded packet by packet in its reader's thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import structlog
from av.error import FFmpegError

from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.capture.file.address import Kind
    from wax.capture.file.demuxer import Coded, Demuxer
    from wax.capture.file.media_file import MediaFile

_LOG = structlog.get_logger(__name__)

_FRUITLESS: Final = 100
"""After this many packets that yield no picture or sound, decoding has failed."""


class StreamDecoder:
    """Decodes one stream; subclasses add `read` to make it a source."""

    kind: Kind

    def __init__(self, file: MediaFile) -> None:
        self._file = file
        self.clock = file.clock
        self._demuxer: Demuxer | None = None
        self._last: Coded | None = None
        self._fruitless = 0
        self._next_pts = 0

    def open(self) -> None:
        """Raise `SourceError` if the file cannot be played or lacks this stream."""
        self.close()
        self._demuxer = self._file.acquire_demuxer()
        try:
            if self.kind not in self._demuxer.kinds():
                raise SourceError(
                    Sentence(
                        "file.no_picture" if self.kind == "video" else "file.no_sound",
                        {"name": self._demuxer.name},
                    )
                )
        except SourceError:
            self.close()
            raise

    def close(self) -> None:
        demuxer, self._demuxer, self._last, self._fruitless = self._demuxer, None, None, 0
        if demuxer is not None:
            self._file.release_demuxer(demuxer)

    @property
    def demuxer(self) -> Demuxer:
        if self._demuxer is None:
            raise SourceError("The file was read before it was opened.")
        return self._demuxer

    def decode_next(self, until_s: float) -> list[tuple[Any, Coded]] | None:
        """Decode one packet into frames; None if none is due before `until_s`.

        Frames left in the decoder at the end of a pass come before the next pass.
        """
        item = self.demuxer.next_packet(self.kind, until_s)
        if item is None:
            return None
        frames: list[tuple[Any, Coded]] = []
        if self._last is not None and self._last.track is not item.track:
            frames += self._decode(self._last, flush=True)
        self._last = item
        frames += self._decode(item)
        self._fruitless = 0 if frames else self._fruitless + 1
        if self._fruitless > _FRUITLESS:
            raise SourceError(Sentence("file.undecodable", {"name": self.demuxer.name}))
        return frames

    def flush(self) -> None:
        """Drop what the decoder still holds; the next packet is a keyframe."""
        if self._last is not None:
            self._last.track.decoder.flush_buffers()

    def _decode(self, item: Coded, *, flush: bool = False) -> list[tuple[Any, Coded]]:
        """Decode a packet, or flush the decoder; a damaged packet yields no frames."""
        try:
            frames = item.track.decoder.decode(None if flush else item.packet)
        except FFmpegError as error:
            _LOG.debug("packet cannot be decoded", kind=self.kind, why=str(error))
            return []
        for frame in frames:
            frame.time_base = item.packet.time_base  # missing in flushed frames
            if frame.pts is None:  # a bare elementary stream: packets were counted
                frame.pts = self._next_pts if frame.dts is None else frame.dts
            self._next_pts = frame.pts + round(item.track.period_s / frame.time_base)
        return [(frame, item) for frame in frames]

    def wait_until(self, moment_s: float) -> None:
        remaining_s = moment_s - self.clock.now_s()
        if remaining_s > 0:
            self._file.sleep(remaining_s)
