"""A program that records until it is killed: ``python -m tests.tape.filming FOLDER CODEC``.

It prints the capture time of each picture, in seconds since the first, once the recorder has it.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar, cast

from tests.tape.packets import SIZE, in_order, pictures, sounds

from wax.clock import SystemClock
from wax.config.recording import RecordingSettings
from wax.encode.encoded import EncodedPicture
from wax.protocol.tape_events import Missed
from wax.tape.camera_files import CameraFormat
from wax.tape.recorder import Format, Recorder
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from wax.encode.encoded import EncodedSound
    from wax.tape.tape_file import Codec

_Item = TypeVar("_Item", "EncodedPicture", "EncodedSound")

_LEAD_S = 0.5
_SECONDS = 8.0
CAMERA_LATER_S = 0.25
"""The other camera begins this much later than the driving view."""


def _moved(one: _Item, by_s: float) -> _Item:
    """Shift an item's capture time by the real time at which recording begins."""
    return replace(one, captured_s=one.captured_s + by_s)


def main(folder: Path, codec: Codec) -> None:
    """Record pictures, a camera and sound at their own speed, and an event with each picture.

    The camera uses the other codec.
    """
    camera = CameraFormat("Door", "vp8" if codec == "h264" else "h264", SIZE)
    made = pictures(codec, begin_s=0.0, seconds=_SECONDS)
    made_beside = pictures(camera.codec, begin_s=CAMERA_LATER_S, seconds=_SECONDS)
    heard = sounds(begin_s=0.0, seconds=_SECONDS)
    clock = SystemClock()
    begin_s = clock.now_s() + _LEAD_S
    recorder = Recorder(
        Shelf(folder),
        settings=RecordingSettings(segment_s=600.0, min_free_gb=0.0),
        format=Format(codec, SIZE, has_sound=True, keyframe_interval_s=1.0, cameras=(camera,)),
        clock=clock,
    )
    beside = [_moved(one, begin_s) for one in made_beside]
    of_camera = {id(one) for one in beside}
    film = [_moved(one, begin_s) for one in made]
    items = in_order([*film, *beside, *(_moved(one, begin_s) for one in heard)])
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
