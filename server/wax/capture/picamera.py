"""A Raspberry Pi's camera module, or any other libcamera camera, through picamera2.

Debian's package `python3-picamera2` installs it for Debian's Python, so it is imported only where
it is used. This is written from its documentation and was never tried on a real camera module.
"""

from __future__ import annotations

import importlib
import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import structlog

from wax.capture.source import REST_S, Picture
from wax.errors import SourceError, reason_of
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.video import VideoSettings

_LOG = structlog.get_logger(__name__)

_SILENT_S: Final = 1.8
_WITHIN_S: Final = 0.04
"""The time from exposing the first row to exposing the last one, at 25 pictures a second."""
_BUFFERS: Final = 4
"""One is being filled, one is being read, and two bridge a short pause of the reader."""


def load_picamera2() -> Any:
    """Import picamera2; raises `SourceError` with the command that installs it."""
    try:
        return importlib.import_module("picamera2").Picamera2
    except ImportError as error:
        raise SourceError(Sentence("picamera.missing")) from error
    except Exception as error:  # libcamera's library is missing or of another version
        raise SourceError(Sentence("picamera.broken", {"why": str(error)})) from error


class PiCamera:
    """The camera that `source` names: ``picamera`` is the first, ``picamera:1`` the second.

    Pictures arrive planar and at the configured size: the camera's own processor scales them.
    `captured_s` is when the sensor began to expose the first row, as libcamera reports it.
    """

    rest_s: Final = REST_S

    def __init__(
        self,
        settings: VideoSettings,
        clock: Clock,
        *,
        load: Callable[[], Any] = load_picamera2,
        boot_s: Callable[[], float] = lambda: time.clock_gettime(time.CLOCK_BOOTTIME),
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._load = load
        self._boot_s = boot_s
        number = settings.source.partition(":")[2]
        self._number = int(number) if number.isdecimal() else 0
        self._camera: Any = None

    @property
    def name(self) -> str:
        return f"picamera:{self._number}"

    def open(self) -> None:
        self.close()
        kind = self._load()
        there = kind.global_camera_info()
        if not there:
            raise SourceError(Sentence("picamera.none"))
        if self._number >= len(there):
            raise SourceError(Sentence("picamera.no_such", {"camera": self._number}))
        try:
            self._camera = kind(self._number)
            self._check_controls()
            self._camera.configure(
                self._camera.create_video_configuration(
                    main={
                        "size": (self._settings.width, self._settings.height),
                        "format": "YUV420",
                    },
                    # Without this it would be BT.709 from 1280×720 upwards.
                    colour_space=importlib.import_module("libcamera").ColorSpace.Smpte170m(),
                    controls={"FrameRate": self._settings.fps, **self._settings.controls},
                    buffer_count=_BUFFERS,
                    queue=False,  # the next picture, not the last one
                )
            )
            self._camera.start()
        except SourceError:
            self.close()
            raise
        except Exception as error:  # libcamera's errors are of many kinds
            self.close()
            raise SourceError(
                Sentence("picamera.not_open", {"camera": self._number, "why": reason_of(error)})
            ) from error

    def read(self) -> Picture:
        if self._camera is None:
            raise SourceError("The camera was read before it was opened.")
        try:
            request = self._camera.wait(self._camera.capture_request(wait=False), _SILENT_S)
        except TimeoutError:
            raise SourceError(Sentence("picamera.silent", {"camera": self._number})) from None
        except Exception as error:
            raise SourceError(
                Sentence("picamera.stopped", {"camera": self._number, "why": reason_of(error)})
            ) from error
        try:
            width, height = request.config["main"]["size"]
            i420 = planar(request.make_array("main"), width, height)
            taken_ns = request.get_metadata().get("SensorTimestamp")
        finally:
            request.release()  # otherwise the camera soon runs out of buffers
        return Picture(i420, *self._captured_s(taken_ns))

    def close(self) -> None:
        camera, self._camera = self._camera, None
        if camera is None:
            return
        for end in (camera.stop, camera.close):
            try:
                end()
            except Exception as error:
                _LOG.warning("a camera does not close", camera=self.name, why=reason_of(error))

    def _check_controls(self) -> None:
        """Raise `SourceError` for a name that libcamera does not have for this camera."""
        for name in self._settings.controls:
            if name not in self._camera.camera_controls:
                there = ", ".join(sorted(self._camera.camera_controls))
                raise SourceError(
                    Sentence(
                        "camera.no_control",
                        {"camera": self._number, "name": name, "there": there},
                    )
                )

    def _captured_s(self, taken_ns: int | None) -> tuple[float, float | None]:
        """Return `captured_s` and `within_s` for libcamera's boot time, which includes sleep.

        An impossible time makes the picture's age unknown.
        """
        now_s = self._clock.now_s()
        if taken_ns is None:
            return now_s, None
        age_s = self._boot_s() - taken_ns / 1e9
        is_one = 0 <= age_s < _SILENT_S
        return (now_s - age_s, _WITHIN_S) if is_one else (now_s, None)


def planar(array: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """Return I420 without the bytes that pad each row to the hardware's alignment.

    `array` holds the rows of luma, then those of both chroma planes, two chroma rows in each row.
    """
    padded = array.shape[1]
    if padded == width:
        return array[: height * 3 // 2]
    chroma = array[height : height * 3 // 2].reshape(height, padded // 2)[:, : width // 2]
    return np.concatenate([array[:height, :width], chroma.reshape(height // 2, width)])
