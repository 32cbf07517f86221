"""Copies the sound of an episode to a file of its own, whose time 0 is the first picture's."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from fractions import Fraction
from typing import TYPE_CHECKING

import av

from wax import state_dir
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from av.audio.stream import AudioStream
    from av.packet import Packet

    Taped = tuple[Path, float]
    """A file of the tape, and its time 0 in seconds since 1970."""

_TIME_BASE = Fraction(1, SAMPLE_RATE_HZ)


def copy_sound(files: Sequence[Taped], path: Path, begin_s: float, end_s: float) -> None:
    """Copy what was heard from `begin_s` until `end_s`; there is no file if nothing was.

    What is damaged is left out. Raises `OSError` or `av.FFmpegError` if `path` cannot be written.
    """
    path.unlink(missing_ok=True)
    stream: AudioStream | None = None
    newest = -1
    with ExitStack() as closing:
        for at_s, packet in _packets(files, begin_s, end_s):
            if stream is None:
                container = closing.enter_context(av.open(str(path), "w", format="ogg"))
                stream = container.add_stream_from_template(packet.stream, opaque=True)
            newest = max(newest + 1, round((at_s - begin_s) * SAMPLE_RATE_HZ))
            packet.pts = packet.dts = newest
            packet.time_base = _TIME_BASE
            packet.stream = stream
            container.mux_one(packet)
    if stream is not None:
        state_dir.sync(path)


def _packets(
    files: Sequence[Taped], begin_s: float, end_s: float
) -> Iterator[tuple[float, Packet[AudioStream]]]:
    for path, origin_s in files:
        with suppress(av.FFmpegError), av.open(str(path), "r") as media:
            for packet in media.demux(media.streams.audio[0]):
                if packet.pts is None or not packet.size:
                    continue
                at_s = origin_s + float(packet.pts * packet.time_base)
                if begin_s <= at_s < end_s:
                    yield at_s, packet
