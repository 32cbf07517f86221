"""Where a sender's packets come from: the lane of one viewer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from av.packet import Packet

    from wax.encode.encoded import EncodedSound


class Encoded(Protocol):
    """A packet and the moment its content was captured, on the server's clock."""

    @property
    def packet(self) -> Packet[Any]: ...

    @property
    def captured_s(self) -> float: ...


class Picture(Encoded, Protocol):
    """`sync` is true where it depends on layer 0 only, `droppable` where nothing depends on it."""

    @property
    def keyframe(self) -> bool: ...

    @property
    def layer(self) -> int: ...

    @property
    def sync(self) -> bool: ...

    @property
    def droppable(self) -> bool: ...


class SoundLane(Protocol):
    """Gives sound in the order of its capture."""

    async def get(self) -> EncodedSound:
        """Wait for the next packet to send."""
        ...

    def offered(self, *, redundancy: bool) -> None:
        """Learn whether the browser takes earlier sound once more (RFC 2198)."""
        ...

    def earlier(self, sound: EncodedSound) -> Sequence[EncodedSound]:
        """Return those just before this one that go with it once more, the oldest first."""
        ...


class PictureLane(Protocol):
    """Gives the picture that is best sent now, when it is asked."""

    def listen(self, on_news: Callable[[], None]) -> None:
        """Call back whenever there is something to take; replaces whoever listened before."""
        ...

    def take(self) -> Picture | None:
        """Return the picture to send now, None where there is none."""
        ...
