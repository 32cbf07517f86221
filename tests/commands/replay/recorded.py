"""A recorded part of a tape, to be replayed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tests.tape.packets import SIZE, pictures, sounds

from wax.protocol.tape_events import Stopped
from wax.tape.camera_files import CameraFormat
from wax.tape.segment import Segment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.tape.shelf import Shelf

BEGIN_S = 1000.0
CAMERAS: Final = (CameraFormat("Door", "vp8", SIZE), CameraFormat("Tail", "h264", SIZE))


def record(shelf: Shelf, begin_s: float, cameras: Sequence[CameraFormat] = ()) -> str:
    """Record two seconds with a stop in the middle; return the part's name.

    Each of `cameras` begins half a second after the one before.
    """
    segment = Segment(
        shelf,
        origin_s=begin_s,
        zero_ns=10**18,
        codec="vp8",
        size=SIZE,
        has_sound=True,
        cameras=cameras,
    )
    for picture in pictures("vp8", begin_s=begin_s, seconds=2.0):
        segment.picture(picture)
    for sound in sounds(begin_s=begin_s, seconds=2.0):
        segment.sound(sound)
    for number, camera in enumerate(cameras):
        for picture in pictures(camera.codec, begin_s=begin_s + number / 2, seconds=1.0):
            segment.camera(number + 1, picture)
    segment.event(Stopped(number=1, pressed=True, viewer=2, by_host=False), begin_s + 1.0)
    segment.close()
    return segment.name
