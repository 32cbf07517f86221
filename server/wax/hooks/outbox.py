"""The queue of a receiver's urgent or other events: ordered, bounded in number and age. Pure."""

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
URGENT_WAIT_S: Final = 10.0
"""The longest wait before a Stop is retried, unless its receiver asks for a longer one."""


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """One event as it is posted; `id` is the same at each retry."""

    id: str
    type: str
    body: bytes
    at_s: float


class Outbox:
    """A queue that sends one message at a time and drops the oldest beyond `MOST`.

    `problem` is why the newest attempt failed; None once an event is accepted or refused for good.
    `refused` counts the events refused for good, `refusal` is why the newest of them was.
    """

    def __init__(self, longest_wait_s: float = _LONGEST_WAIT_S) -> None:
        self._longest_wait_s = longest_wait_s
        self._waiting: deque[Message] = deque()
        self._failures = 0
        self._again_s = float("-inf")
        self.taken = 0
        self.lost = self.refused = 0
        self.problem: Sentence | None = None
        self.refusal: Sentence | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Message) -> None:
        if len(self._waiting) >= MOST:
            self._lose()
        self._waiting.append(message)

    def due(self, now_s: float) -> Message | None:
        """Return the message to post now; drop those older than `KEPT_S`."""
        while self._waiting and now_s - self._waiting[0].at_s > KEPT_S:
            self._lose()
        return self.first if now_s >= self._again_s else None

    @property
    def first(self) -> Message | None:
        """The oldest message, due or not."""
        return self._waiting[0] if self._waiting else None

    def delivered(self, message: Message) -> None:
        """Note that the receiver accepted a message."""
        self._answered(message)
        self.taken += 1

    def refuse(self, message: Message, why: Sentence) -> None:
        """Note that the receiver refused a message for good; it holds up none behind it."""
        self._answered(message)
        self.refused += 1
        self.refusal = why

    def failed(self, why: Sentence, now_s: float, asked_s: float = 0.0) -> None:
        """Note a failed attempt: back off, at least for as long as the receiver asks."""
        self.problem = why
        wait_s = min(_FIRST_WAIT_S * 2**self._failures, self._longest_wait_s)
        self._again_s = now_s + max(wait_s, asked_s)
        self._failures = min(self._failures + 1, 10)

    def drop_all(self) -> None:
        """Drop the whole backlog: the receiver will never accept it."""
        self.lost += len(self._waiting)
        self._waiting.clear()

    def _answered(self, message: Message) -> None:
        if self.first is message:  # otherwise it has been dropped as the oldest, and counted
            self._waiting.popleft()
        self._failures, self.problem = 0, None

    def _lose(self) -> None:
        self._waiting.popleft()
        self.lost += 1
