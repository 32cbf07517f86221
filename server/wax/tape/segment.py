"""One part of the tape while it is written: a group of files that end together.

A camera's file begins with its first keyframe, the other two with the part.
"""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Final

import av

from wax import state_dir
from wax.protocol.tape_events import Filmed
from wax.tape.camera_files import CameraFiles
from wax.tape.event_file import EventFile
from wax.tape.shelf import EVENTS
from wax.tape.tape_file import ENDINGS, TapeFile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.encode.encoded import EncodedPicture, EncodedSound
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.camera_files import CameraFormat
    from wax.tape.shelf import Shelf
    from wax.tape.tape_file import Codec

WRITE_ERRORS: Final = (OSError, av.FFmpegError)
"""The errors of a file that cannot be written."""


class Segment:
    """The open files of a part; only `has_camera` is thread-safe.

    The constructor and all other methods may raise one of `WRITE_ERRORS`.
    """

    def __init__(
        self,
        shelf: Shelf,
        *,
        origin_s: float,
        zero_ns: int,
        codec: Codec,
        size: tuple[int, int] | None,
        has_sound: bool,
        sound_channels: int = 1,
        cameras: Sequence[CameraFormat] = (),
    ) -> None:
        self._folder = shelf.folder
        self.name = shelf.new_name((zero_ns + origin_s * 1e9) / 1e6)
        self._formats = cameras
        self._cameras = CameraFiles(shelf, self.name, cameras, origin_s=origin_s)
        self._events = EventFile(shelf.path(self.name, EVENTS), origin_s=origin_s, zero_ns=zero_ns)
        self._media: TapeFile | None = None
        if size is not None or has_sound:
            try:
                self._media = TapeFile(
                    shelf.path(self.name, ENDINGS[codec]),
                    codec=codec,
                    size=size,
                    has_sound=has_sound,
                    sound_channels=sound_channels,
                    origin_s=origin_s,
                )
            except BaseException:
                with suppress(*WRITE_ERRORS):
                    self._events.close()
                raise

    def picture(self, picture: EncodedPicture) -> None:
        if self._media is not None:
            self._media.picture(picture)

    def sound(self, sound: EncodedSound) -> None:
        if self._media is not None:
            self._media.sound(sound)

    def camera(self, camera: int, picture: EncodedPicture) -> None:
        """Add a picture of a camera other than the driving view; these count from 1."""
        if self._cameras.picture(camera, picture):
            filmed = Filmed(camera=camera, name=self._formats[camera - 1].name)
            self._events.write(filmed, picture.captured_s)

    def has_camera(self, camera: int) -> bool:
        """Return whether this camera's file has been started; thread-safe."""
        return self._cameras.has(camera)

    def event(self, event: TapeEvent, at_s: float) -> None:
        self._events.write(event, at_s)

    def flush(self) -> None:
        """Flush, so that a kill of this process loses only the newest half a second."""
        self._events.flush()

    def sync(self) -> None:
        """Sync to disk, so that a power cut now loses only the newest half a second."""
        self._events.sync()
        if self._media is not None:
            self._media.sync()
        self._cameras.sync()
        state_dir.sync(self._folder)  # a camera's file may be new in it

    def close(self) -> None:
        """Finish all files, even if one of them fails.

        The events are finished last, so that their end proves that the other files were closed.
        """
        with ExitStack() as closing:
            closing.callback(self._events.close)
            if self._media is not None:
                closing.callback(self._media.close)
            closing.callback(self._cameras.close)
