"""Adaptive source skipping: one viewer's cache of pictures (thesis 3.3.4)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from wax.baseline.media_units import SourceSlot

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit


class PictureCache:
    """Up to `capacity` pictures in order, and beside them the slot with the newest.

    A picture comes into the cache only while a place in it is empty, so one that is in it is
    replaced by the newest only when its place has been sent: the rate follows the link.
    """

    def __init__(self) -> None:
        self._pictures: deque[MediaUnit] = deque()
        self._slot = SourceSlot()
        self._capacity = 0

    @property
    def pictures(self) -> tuple[MediaUnit, ...]:
        """What is in it, oldest first; the slot is not counted."""
        return tuple(self._pictures)

    @property
    def newest(self) -> MediaUnit | None:
        """What is in the slot: the newest captured, unless it went into the cache."""
        return self._slot.held

    @property
    def capacity(self) -> int:
        return self._capacity

    @property
    def is_full(self) -> bool:
        return len(self._pictures) >= self._capacity

    def put(self, picture: MediaUnit, now_s: float) -> list[MediaUnit]:
        """Take a picture just captured; return what was skipped by that."""
        replaced = self._slot.put(picture, now_s)
        self.fill()
        return [] if replaced is None else [replaced]

    def fill(self) -> None:
        """Let the newest into an empty place, if there is one."""
        if not self.is_full and (newest := self._slot.take()) is not None:
            self._pictures.append(newest)

    def resize(self, capacity: int) -> list[MediaUnit]:
        """Change the number of places; return the oldest, for which there is none any more.

        The last of them goes back to the slot rather than be lost, if that is empty.
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
        """Take the one whose turn it is; the newest when there is nothing in the cache."""
        return self._pictures.popleft() if self._pictures else self._slot.take()

    def skip_before(self, number: int) -> list[MediaUnit]:
        """Drop what is older than that picture; return it."""
        skipped = []
        while self._pictures and self._pictures[0].number < number:
            skipped.append(self._pictures.popleft())
        return skipped
