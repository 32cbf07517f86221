"""A camera through OpenCV: V4L2 on Linux, AVFoundation on macOS, Media Foundation on Windows."""

from __future__ import annotations

import errno
import os
import sys
import threading
from typing import TYPE_CHECKING, Any, Final, Protocol

import cv2
import structlog

from wax.capture.letterbox import fit_bgr
from wax.capture.source import REST_S, Picture
from wax.capture.v4l2_controls import set_controls
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.video import VideoSettings

_LOG = structlog.get_logger(__name__)

_SILENT_S: Final = 1.8
"""A camera without a picture for this long is unplugged or hung (the interface allows 2 s)."""

_AHEAD: Final = 4
"""So many frames are decoded after each read has begun. The last of them counts as old, because
others may have been passed over since."""

_OPEN_S: Final = 8.0
_RAW_MAX_BYTES_PER_S: Final = 20_000_000
"""More than this does not fit through USB 2 uncompressed: request Motion JPEG."""

_WITHIN_S: Final = 0.1
"""Exposure and transfer take 20 to 60 ms on common USB cameras, and one frame may be queued."""

_IS_MAC: Final = sys.platform == "darwin"
_IS_LINUX: Final = sys.platform.startswith("linux")


class VideoDevice(Protocol):
    """The part of `cv2.VideoCapture` that is used."""

    def isOpened(self) -> bool: ...  # noqa: N802 - OpenCV's name

    def set(self, propId: int, value: float, /) -> bool: ...  # noqa: N803 - OpenCV's name

    def grab(self) -> bool: ...

    def retrieve(self) -> tuple[bool, Any]: ...

    def release(self) -> None: ...


def open_device(device: int | str) -> VideoDevice:
    """Open by number or path, through V4L2 if available."""
    # OpenCV logs several lines at each attempt to open a missing camera.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    backend = cv2.CAP_V4L2 if _IS_LINUX else cv2.CAP_ANY
    return cv2.VideoCapture(device, backend)


class OpenCvCamera:
    """A camera by number (``0``) or path (``/dev/video0``), at the size and rate of the settings.

    OpenCV returns BGR. It decodes Motion JPEG as full range and all other YUV as BT.601 in limited
    range, which is V4L2's default where a driver does not say otherwise.

    If the camera delivers another size, the picture is scaled in proportion, with bars.
    `captured_s` is when OpenCV received the frame.

    OpenCV's reads cannot be interrupted (V4L2 waits 10 s for a frame), so each opening has a thread
    that grabs every frame and decodes the next few after each `read` has begun, which gives up
    on it after 1.8 s. A hung thread is abandoned: it releases the device when OpenCV returns.
    """

    rest_s: Final = REST_S

    def __init__(
        self,
        settings: VideoSettings,
        clock: Clock,
        *,
        device: int | str = 0,
        open_device: Callable[[int | str], VideoDevice] = open_device,
        set_controls: Callable[[int | str, Mapping[str, float]], None] = set_controls,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._device = device
        self._open_device = open_device
        self._set_controls = set_controls
        self._grabber: _Grabber | None = None

    @property
    def name(self) -> str:
        return f"Camera {self._device}"

    def open(self) -> None:
        self.close()
        self._grabber = _Grabber(self._make, self._clock, self._device)
        self._grabber.wait_until_open(_OPEN_S)

    def read(self) -> Picture:
        if self._grabber is None:
            raise SourceError(f"{self.name} was read before it was opened.")
        bgr, captured_s = self._grabber.newest(_SILENT_S)
        fitted = fit_bgr(bgr, self._settings.width, self._settings.height)
        return Picture.from_bgr(fitted, captured_s, _WITHIN_S)

    def close(self) -> None:
        grabber, self._grabber = self._grabber, None
        if grabber is not None:
            grabber.stop()

    def _make(self) -> VideoDevice:
        width, height, fps = self._settings.width, self._settings.height, self._settings.fps
        device = self._open_device(self._device)
        if not device.isOpened():
            device.release()
            raise SourceError(_why_not_open(self._device))
        if width * height * 2 * fps > _RAW_MAX_BYTES_PER_S:
            # The format comes first: it decides which sizes and rates V4L2 offers.
            device.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG"))
        device.set(cv2.CAP_PROP_FRAME_WIDTH, width)
        device.set(cv2.CAP_PROP_FRAME_HEIGHT, height)
        device.set(cv2.CAP_PROP_FPS, fps)
        device.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        try:
            self._set_controls(self._device, self._settings.controls)
        except SourceError:
            device.release()
            raise
        return device


def _why_not_open(device: int | str) -> Sentence:
    """Say what to do. OpenCV gives no reason, so the operating system is asked for one."""
    if _IS_LINUX:
        path = f"/dev/video{device}" if isinstance(device, int) else device
        try:
            os.close(os.open(path, os.O_RDWR | os.O_NONBLOCK))
        except OSError as error:
            if error.errno in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
                return Sentence("camera.missing", {"camera": device})
            if error.errno in (errno.EACCES, errno.EPERM):
                return Sentence("camera.forbidden", {"camera": device})
    return Sentence("camera.not_open_mac" if _IS_MAC else "camera.not_open", {"camera": device})


class _Grabber:
    """The thread that grabs every frame of the camera, decodes what is read and runs ahead of it.

    A frame is kept until it is taken, becomes old, or a newer one is decoded.
    """

    def __init__(self, make: Callable[[], VideoDevice], clock: Clock, device: int | str) -> None:
        self._make = make
        self._clock = clock
        self._device = device
        self._condition = threading.Condition()
        self._opened = False
        self._to_decode = _AHEAD
        self._newest: tuple[NDArray[np.uint8], float] | None = None
        self._failure: SourceError | None = None
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name=f"camera {device}", daemon=True)
        self._thread.start()

    def wait_until_open(self, timeout_s: float) -> None:
        with self._condition:
            self._condition.wait_for(lambda: self._opened or self._failure, timeout_s)
            if not self._opened:
                raise self._failure or SourceError(
                    Sentence("camera.hangs", {"camera": self._device})
                )

    def newest(self, timeout_s: float) -> tuple[NDArray[np.uint8], float]:
        """Return the kept frame, else the next one; no frame is returned twice."""
        with self._condition:
            if not self._to_decode:
                self._newest = None
            self._to_decode = _AHEAD
            self._condition.wait_for(lambda: self._newest or self._failure, timeout_s)
            found, self._newest = self._newest, None
            if found is None:
                raise self._failure or SourceError(
                    Sentence("camera.no_picture", {"camera": self._device})
                )
            return found

    def stop(self) -> None:
        self._stopping = True
        self._thread.join(timeout=0.5)

    def _run(self) -> None:
        try:
            device = self._make()
            try:
                self._set_opened()
                while not self._stopping:
                    self._grab(device)
            finally:
                device.release()
        except SourceError as error:
            self._fail(error)
        except Exception as error:
            _LOG.exception("camera failed", camera=self._device)
            self._fail(
                SourceError(Sentence("camera.broke", {"camera": self._device, "why": str(error)}))
            )

    def _grab(self, device: VideoDevice) -> None:
        if not device.grab():
            raise SourceError(Sentence("camera.stopped", {"camera": self._device}))
        captured_s = self._clock.now_s()
        if not self._to_decode:
            return
        good, bgr = device.retrieve()
        if good:  # otherwise a Motion JPEG picture is damaged: wait for the next
            with self._condition:
                self._newest = (bgr, captured_s)
                self._to_decode -= 1
                self._condition.notify_all()

    def _set_opened(self) -> None:
        with self._condition:
            self._opened = True
            self._condition.notify_all()

    def _fail(self, error: SourceError) -> None:
        with self._condition:
            self._failure = error
            self._condition.notify_all()
