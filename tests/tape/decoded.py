"""What a recorded file shows and sounds when it is decoded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import av
import numpy as np
from tests.tape.packets import SIZE

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


Stream = Literal["video", "audio"]


def frames(path: Path, stream: Stream) -> Iterator[av.VideoFrame | av.AudioFrame]:
    """Decode as far as possible."""
    with av.open(str(path)) as media:
        for frame in media.decode(**{stream: 0}):
            assert isinstance(frame, av.VideoFrame | av.AudioFrame)
            yield frame


def times_s(path: Path, stream: Stream) -> list[float]:
    """Return the start of each decodable frame."""
    return [frame.time or 0.0 for frame in frames(path, stream)]


def flashes_s(path: Path, stream: Stream) -> list[float]:
    """Return the times at which picture or sound become bright or loud."""
    found, was_on = [], False
    for frame in frames(path, stream):
        begin_s = frame.time or 0.0
        if isinstance(frame, av.AudioFrame):
            samples = np.abs(frame.to_ndarray().astype(np.float64)).ravel()
            pieces = [
                (begin_s + at / frame.sample_rate, bool(samples[at : at + 48].max() > 0.05))
                for at in range(0, len(samples), 48)
            ]
        else:
            pieces = [(begin_s, bool(frame.to_ndarray()[: SIZE[1]].mean() > 128))]
        for at_s, is_on in pieces:
            if is_on and not was_on:
                found.append(at_s)
            was_on = is_on
    return found
