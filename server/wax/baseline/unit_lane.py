"""The input and output of a viewer served in media units: pictures in, units out."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from wax.encode.encoded import EncodedPicture, EncodedSound


ItemT = TypeVar("ItemT", "EncodedPicture", "EncodedSound")


class UnitLane(Generic[ItemT]):
    """Returns one media unit's packets without pauses, then waits for the next unit.

    It needs no bound: a unit is added only after the previous one was acknowledged or lost.
    """

    def __init__(self) -> None:
        self._queue: deque[ItemT] = deque()
        self._on_news: Callable[[], None] = _nobody

    def set_listener(self, on_news: Callable[[], None]) -> None:
        """Set the callback for new packets."""
        self._on_news = on_news

    def put(self, packets: Iterable[ItemT]) -> None:
        self._queue.extend(packets)
        self._on_news()

    def pop_next(self) -> ItemT | None:
        """Return the next packet to send, None if there is none."""
        return self._queue.popleft() if self._queue else None

    @property
    def is_empty(self) -> bool:
        return not self._queue

    def set_redundancy(self, *, is_accepted: bool) -> None: ...  # none is sent

    def packets_to_repeat(self, sound: object) -> Sequence[EncodedSound]:  # noqa: ARG002  # the interface of a lane
        """Repeat nothing: the page skips a lost unit."""
        return ()


class PictureIntake:
    """Numbers the pictures of the one rendition as media units and passes them on.

    For the fan-out it is a lane, but it queues nothing.
    """

    def __init__(self, take: Callable[[int, EncodedPicture], None]) -> None:
        self._take = take
        self._number = 0
        self.rendition: str | None = None
        self.dropped = 0

    def choose(self, rendition: str | None) -> None:
        self.rendition = rendition

    def takes(self, rendition: str) -> bool:
        return rendition == self.rendition

    def put(self, picture: EncodedPicture) -> None:
        if picture.rendition == self.rendition:
            self._number += 1
            self._take(self._number, picture)


def _nobody() -> None: ...
