"""Adaptive source skipping: one viewer's cache of pictures (thesis 3.3.4)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from wax.baseline.media_units import SourceSlot

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit


class PictureCache:
    """Up to `capacity` pictures in order, and a slot for the newest.

    The newest enters the cache only when a place is free, that is, after a picture has been sent,
    so that the rate follows the link.
    """

    def __init__(self) -> None:
        self._pictures: deque[MediaUnit] = deque()
        self._slot = SourceSlot()
        self._capacity = 0

    @property
    def pictures(self) -> tuple[MediaUnit, ...]:
        """The cached pictures, oldest first, without the slot."""
        return tuple(self._pictures)

    @property
    def newest(self) -> MediaUnit | None:
        """The picture in the slot: the newest, unless it entered the cache."""
        return self._slot.held

    @property
    def capacity(self) -> int:
        return self._capacity

    @property
    def is_full(self) -> bool:
        return len(self._pictures) >= self._capacity

    def put(self, picture: MediaUnit, now_s: float) -> list[MediaUnit]:
        """Add a captured picture; return the pictures that are thereby skipped."""
        replaced = self._slot.put(picture, now_s)
        self.fill()
        return [] if replaced is None else [replaced]

    def fill(self) -> None:
        """Move the newest into a free place, if there is one."""
        if not self.is_full and (newest := self._slot.take()) is not None:
            self._pictures.append(newest)

    def resize(self, capacity: int) -> list[MediaUnit]:
        """Change the number of places; return the oldest pictures, which no longer fit.

        The last of them goes back to the slot if that is empty.
        """
        self._capacity = capacity
        skipped = []
        while len(self._pictures) > capacity:
            skipped.append(self._pictures.popleft())
        if not capacity and skipped and self._slot.held is None:
            self._slot.put(skipped.pop(), 0.0)
        self.fill()
        return skipped

    def take_oldest(self) -> MediaUnit | None:
        """Take the oldest cached picture, or the newest if the cache is empty."""
        return self._pictures.popleft() if self._pictures else self._slot.take()

    def skip_before(self, number: int) -> list[MediaUnit]:
        """Drop and return all pictures older than this one."""
        skipped = []
        while self._pictures and self._pictures[0].number < number:
            skipped.append(self._pictures.popleft())
        return skipped
