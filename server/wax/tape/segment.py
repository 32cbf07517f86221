"""One part of the tape while it is written: its two files, which begin and end together."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Final

import av

from wax.tape.event_file import EventFile
from wax.tape.media_file import ENDINGS, MediaFile
from wax.tape.shelf import EVENTS

if TYPE_CHECKING:
    from wax.encode.encoded import EncodedPicture, EncodedSound
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.media_file import Codec
    from wax.tape.shelf import Shelf

WRITE_ERRORS: Final = (OSError, av.FFmpegError)
"""What a file that cannot be written raises."""


class Segment:
    """Not thread-safe; the constructor and all methods may raise one of `WRITE_ERRORS`."""

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
    ) -> None:
        self.name = shelf.new_name((zero_ns + origin_s * 1e9) / 1e6)
        self._events = EventFile(shelf.path(self.name, EVENTS), origin_s=origin_s, zero_ns=zero_ns)
        self._media: MediaFile | None = None
        if size is not None or has_sound:
            try:
                self._media = MediaFile(
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

    def event(self, event: TapeEvent, at_s: float) -> None:
        self._events.write(event, at_s)

    def flush(self) -> None:
        """See that no more than the newest half a second is lost if this process is killed."""
        self._events.flush()

    def close(self) -> None:
        """Finish both files, the second even where the first fails."""
        try:
            self._events.close()
        finally:
            if self._media is not None:
                self._media.close()
