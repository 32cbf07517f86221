"""One part of the tape while it is written: its files, which end together.

The cameras' begin when these have their first keyframe, the other two with the part.
"""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Final

import av

from wax import state_dir
from wax.protocol.tape_events import Filmed
from wax.tape.camera_files import CameraFiles
from wax.tape.event_file import EventFile
from wax.tape.media_file import ENDINGS, TapeFile
from wax.tape.shelf import EVENTS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.encode.encoded import EncodedPicture, EncodedSound
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.camera_files import CameraFormat
    from wax.tape.media_file import Codec
    from wax.tape.shelf import Shelf

WRITE_ERRORS: Final = (OSError, av.FFmpegError)
"""What a file that cannot be written raises."""


class Segment:
    """Not thread-safe but for `has_camera`.

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
        """Add a picture of a camera beside the driving view; they count from 1."""
        if self._cameras.picture(camera, picture):
            filmed = Filmed(camera=camera, name=self._formats[camera - 1].name)
            self._events.write(filmed, picture.captured_s)

    def has_camera(self, camera: int) -> bool:
        """Whether the pictures of this camera have begun, from any thread."""
        return self._cameras.has(camera)

    def event(self, event: TapeEvent, at_s: float) -> None:
        self._events.write(event, at_s)

    def flush(self) -> None:
        """See that no more than the newest half a second is lost if this process is killed."""
        self._events.flush()

    def sync(self) -> None:
        """See that no more than the newest half a second is lost if the power is cut now."""
        self._events.sync()
        if self._media is not None:
            self._media.sync()
        self._cameras.sync()
        state_dir.sync(self._folder)  # where a camera's file may be new

    def close(self) -> None:
        """Finish all files, also where one of them fails.

        The events come last: where they have an end, the rest of the part was closed, too.
        """
        with ExitStack() as closing:
            closing.callback(self._events.close)
            if self._media is not None:
                closing.callback(self._media.close)
            closing.callback(self._cameras.close)
