"""The thesis's pictures: each independent and of about one size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np

from wax.baseline.streams import thesis_video
from wax.capture.testcard import TestCardVideo
from wax.clock import SystemClock
from wax.config.settings import Settings
from wax.config.video import VideoSettings
from wax.encode.video_encoder import IntraEncoder

if TYPE_CHECKING:
    from wax.encode.encoded import EncodedPicture


def _pictures(count: int) -> list[EncodedPicture]:
    settings = Settings()
    rendition = thesis_video(settings.video, settings.thesis).renditions[0]
    encoder = IntraEncoder(rendition)
    card = TestCardVideo(
        VideoSettings(source="testcard", width=166, height=130, fps=60.0), SystemClock()
    )
    card.open()
    made = [encoder.encode(card.read(), keyframe=False) for _ in range(count)]
    card.close()
    return [picture for picture in made if picture is not None]


def test_each_picture_can_be_seen_alone() -> None:
    """Each picture decodes alone, in the thesis's size to the nearest even number."""
    for picture in _pictures(5):
        assert picture.keyframe
        decoder = av.CodecContext.create("vp8", "r")
        assert isinstance(decoder, av.VideoCodecContext)
        (frame,) = decoder.decode(av.Packet(picture.data))
        assert (frame.width, frame.height) == (166, 130)


def test_a_picture_is_of_about_eight_kilobytes() -> None:
    """Like the thesis's JPEGs, no picture takes twice as long as another."""
    sizes = [len(picture.data) for picture in _pictures(20)]
    assert 6400 < np.mean(sizes) < 9600
    assert max(sizes) < 1.3 * min(sizes)
