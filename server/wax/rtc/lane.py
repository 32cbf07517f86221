"""The source of a sender's packets: one viewer's lane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.encode.encoded import EncodedSound


class Encoded(Protocol):
    """An encoder's output, its media time, and its capture time on the server's clock."""

    @property
    def data(self) -> bytes: ...

    @property
    def pts(self) -> int: ...

    @property
    def captured_s(self) -> float: ...


class LanePicture(Encoded, Protocol):
    """A picture: `sync` if it depends only on layer 0, `droppable` if nothing depends on it."""

    @property
    def keyframe(self) -> bool: ...

    @property
    def layer(self) -> int: ...

    @property
    def sync(self) -> bool: ...

    @property
    def droppable(self) -> bool: ...


class Lane(Protocol):
    """Notifies its sender when there is something to send."""

    def set_listener(self, on_news: Callable[[], None]) -> None:
        """Set the callback for when there is something to send, replacing the previous one."""
        ...


class SoundLane(Lane, Protocol):
    """Returns sound in the order of capture."""

    def pop_next(self) -> EncodedSound | None:
        """Return the next packet to send, None if there is none."""
        ...

    def set_redundancy(self, *, is_accepted: bool) -> None:
        """Set whether the browser accepts redundant sound (RFC 2198)."""
        ...

    def packets_to_repeat(self, sound: EncodedSound) -> Sequence[EncodedSound]:
        """Return the preceding packets to repeat with this one, the oldest first."""
        ...


class PictureLane(Lane, Protocol):
    """Returns the best picture to send now."""

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to send."""
        ...

    def pop_next(self) -> LanePicture | None:
        """Return the picture to send now, None if there is none."""
        ...
