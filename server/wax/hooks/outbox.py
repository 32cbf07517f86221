"""What waits for one receiver: in order, bounded in number and age. Pure."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.sentence import Sentence

MOST: Final = 200
KEPT_S: Final = 600.0
_FIRST_WAIT_S: Final = 1.0
_LONGEST_WAIT_S: Final = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """One event as it is posted; `id` is the same each time it is tried."""

    id: str
    type: str
    body: bytes
    at_s: float


class Outbox:
    """Only the first is ever under way; of more than `MOST` the oldest is lost.

    `problem` is why the newest attempt failed, None once one has not.
    """

    def __init__(self) -> None:
        self._waiting: deque[Message] = deque()
        self._failures = 0
        self._again_s = float("-inf")
        self.taken = 0
        self.lost = 0
        self.problem: Sentence | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Message) -> None:
        if len(self._waiting) >= MOST:
            self._lose()
        self._waiting.append(message)

    def due(self, now_s: float) -> Message | None:
        """Return what is to be posted now; what was in vain for `KEPT_S` is lost."""
        while self._waiting and now_s - self._waiting[0].at_s > KEPT_S:
            self._lose()
        return self.first if now_s >= self._again_s else None

    @property
    def first(self) -> Message | None:
        """What is next, whenever that is."""
        return self._waiting[0] if self._waiting else None

    def took(self, message: Message) -> None:
        """Note that a message has arrived."""
        if self.first is message:  # else it was pushed out meanwhile, and counted
            self._waiting.popleft()
        self.taken += 1
        self._failures, self.problem = 0, None

    def failed(self, why: Sentence, now_s: float) -> None:
        """Note an attempt in vain: the next is later, up to a minute."""
        self.problem = why
        self._again_s = now_s + min(_FIRST_WAIT_S * 2**self._failures, _LONGEST_WAIT_S)
        self._failures = min(self._failures + 1, 10)

    def _lose(self) -> None:
        self._waiting.popleft()
        self.lost += 1
