"""The newest-frame slot: the writer never waits, and readers see only the newest item."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class NewestSlot(Generic[T]):
    """Holds one item; a newer one replaces it (source preventive skipping, thesis 2.9.3).

    Any thread may put, and any number of threads may wait, each at its own pace. While `needed` is
    not set, nobody waits for new items, and a source may rest (`SourceThread`).
    """

    def __init__(self) -> None:
        self.needed = threading.Event()
        self._condition = threading.Condition()
        self._item: T | None = None
        self._number = 0

    @property
    def count(self) -> int:
        """How many items have ever been put."""
        return self._number

    def put(self, item: T) -> None:
        """Replace the item and wake all waiting threads."""
        with self._condition:
            self._item = item
            self._number += 1
            self._condition.notify_all()

    def wake(self) -> None:
        """Make all waiting threads return without an item, so that they can end."""
        with self._condition:
            self._condition.notify_all()

    def newer_than(self, number: int, timeout_s: float) -> tuple[int, T] | None:
        """Wait for an item with a higher number; return None after `timeout_s` or `wake`."""
        with self._condition:
            if self._item is None or self._number <= number:
                self._condition.wait(timeout_s)
            if self._number <= number or self._item is None:
                return None
            return self._number, self._item
