"""What decoders make of encoded pictures and sound."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np
from av.packet import Packet

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.encode.encoded import EncodedPicture, EncodedSound


def decoded_pictures(pictures: list[EncodedPicture]) -> dict[float, bytes]:
    """Return a VP8 decoder's output for these pictures, by capture time."""
    decoder = av.CodecContext.create("vp8", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    return {
        one.captured_s: frame.to_ndarray().tobytes()
        for one in pictures
        for frame in decoder.decode(Packet(one.data))
    }


def decoded_sound(sounds: list[EncodedSound], layout: str = "mono") -> NDArray[np.float64]:
    """Return an Opus decoder's samples for these packets, one after the other."""
    decoder = av.CodecContext.create("libopus", "r")
    assert isinstance(decoder, av.AudioCodecContext)
    decoder.sample_rate, decoder.layout, decoder.format = SAMPLE_RATE_HZ, layout, "s16"
    frames = [frame for one in sounds for frame in decoder.decode(Packet(one.data))]
    return np.concatenate([frame.to_ndarray().reshape(-1) for frame in frames]).astype(float)
