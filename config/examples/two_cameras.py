"""A camera of your own: two cameras as one picture, side by side.

    [video]
    source = "two_cameras:TwoCameras"

Start the server with this folder in PYTHONPATH.
"""

import cv2
import numpy as np

from wax.capture.source import Picture
from wax.clock import Clock
from wax.config.video import VideoSettings
from wax.errors import SourceError

DEVICES = ("/dev/video0", "/dev/video2")  # left and right, as `wax devices` lists them
WITHIN_S = 0.15  # exposure and USB take up to 0.1 s, and one may be a picture behind the other


class TwoCameras:
    def __init__(self, _: VideoSettings, clock: Clock) -> None:
        self._clock = clock
        self._eyes = [cv2.VideoCapture() for _ in DEVICES]

    def open(self) -> None:
        if not all(map(cv2.VideoCapture.open, self._eyes, DEVICES)):
            raise SourceError(f"{' or '.join(DEVICES)} cannot be opened: is it plugged in?")

    def read(self) -> Picture:
        grabbed = [eye.grab() for eye in self._eyes]  # both are captured before one is decoded
        captured_s = self._clock.now_s()
        if not all(grabbed):
            raise SourceError("One of the two cameras delivers nothing: check its cable.")
        both = np.hstack([eye.retrieve()[1] for eye in self._eyes], dtype=np.uint8)
        return Picture.from_bgr(both, captured_s, WITHIN_S)

    def close(self) -> None:
        for eye in self._eyes:
            eye.release()
