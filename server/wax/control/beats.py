"""Beats: random words by which the server knows what a page has heard, and when. Pure.

Whoever names one cannot have sent that before the server sent the beat, and cannot have guessed it:
no clock but the server's is believed. Only the newest count.
"""

from __future__ import annotations

import math
import secrets
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

EVERY_S: Final = 0.1
THIN_EVERY_S: Final = 0.15
"""Over a thin link, where ten a second would take a fifth of what a modem carries. One may be lost
without a command counting as too old for it."""
_KEPT: Final = 64


def _random() -> str:
    """Return 32 random bits in six characters, since a modem's uplink carries one in each command.

    At 100 messages a second a page guesses one in force about once in 50 days.
    """
    return secrets.token_urlsafe(4)


class Beats:
    """The beats that were sent to one page, in seconds on the server's clock."""

    def __init__(self, word: Callable[[], str] = _random) -> None:
        self._word = word
        self._sent_s: dict[str, float] = {}
        self._newest_s = -math.inf

    def send(self, now_s: float) -> str:
        """Return a new one, which is sent now."""
        word = self._word()
        self._sent_s.pop(word, None)
        self._sent_s[word] = self._newest_s = now_s
        if len(self._sent_s) > _KEPT:
            del self._sent_s[next(iter(self._sent_s))]
        return word

    def is_due(self, now_s: float, *, is_thin: bool) -> bool:
        """Whether somebody who sends commands shall hear another."""
        return now_s - self._newest_s >= (THIN_EVERY_S if is_thin else EVERY_S)

    def sent_s(self, word: str | None) -> float:
        """Return when this one was sent, minus infinity if it was not, or long ago."""
        return -math.inf if word is None else self._sent_s.get(word, -math.inf)
