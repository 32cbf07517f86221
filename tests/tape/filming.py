"""A program that records until it is killed: ``python -m tests.tape.filming FOLDER CODEC``.

It prints the capture time of each picture, in seconds since the first, once the recorder has it.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, cast

from tests.tape.packets import SIZE, in_order, pictures, sounds

from wax.clock import SystemClock
from wax.config.recording import RecordingSettings
from wax.encode.encoded import EncodedPicture
from wax.protocol.tape_events import Missed
from wax.tape.camera_files import CameraFormat
from wax.tape.recorder import Format, Recorder
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from wax.tape.media_file import Codec

_LEAD_S = 1.5
_SECONDS = 8.0
CAMERA_LATER_S = 0.25
"""So much later than the driving view a camera beside it begins."""


def main(folder: Path, codec: Codec) -> None:
    """Record pictures, a camera and sound at their own speed, and an event with each picture.

    The camera has the other codec.
    """
    camera = CameraFormat("Door", "vp8" if codec == "h264" else "h264", SIZE)
    clock = SystemClock()
    begin_s = clock.now_s() + _LEAD_S
    recorder = Recorder(
        Shelf(folder),
        settings=RecordingSettings(segment_s=600.0, min_free_gb=0.0),
        format=Format(codec, SIZE, has_sound=True, keyframe_interval_s=1.0, cameras=(camera,)),
        clock=clock,
    )
    film = pictures(codec, begin_s=begin_s, seconds=_SECONDS)
    beside = pictures(camera.codec, begin_s=begin_s + CAMERA_LATER_S, seconds=_SECONDS)
    of_camera = {id(one) for one in beside}
    items = in_order([*film, *beside, *sounds(begin_s=begin_s, seconds=_SECONDS)])
    recorder.start()
    for item in items:
        time.sleep(max(0.0, item.captured_s - clock.now_s()))
        if isinstance(item, EncodedPicture) and id(item) in of_camera:
            recorder.camera(1, item)
        elif isinstance(item, EncodedPicture):
            recorder.picture(item)
            recorder.event(Missed(missed_s=0.0), item.captured_s)
            sys.stdout.write(f"{item.captured_s - begin_s:.3f}\n")
            sys.stdout.flush()
        else:
            recorder.sound(item)
    time.sleep(60)


if __name__ == "__main__":
    main(Path(sys.argv[1]), cast("Codec", sys.argv[2]))
