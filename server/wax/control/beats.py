"""Beats: random tokens that prove how recent a page's message is. Pure.

A message that quotes a beat was sent after the server sent that beat, since nobody can guess one:
the server trusts no clock but its own. Only the newest `_KEPT` beats count.
"""

from __future__ import annotations

import math
import secrets
from typing import TYPE_CHECKING, Final

from wax.bounded_dict import BoundedDict

if TYPE_CHECKING:
    from collections.abc import Callable

EVERY_S: Final = 0.1
THIN_EVERY_S: Final = 0.15
"""The interval on a thin link: ten beats a second would take a fifth of a modem's rate. Losing one
beat does not make a command too old."""
_KEPT: Final = 64


def _random() -> str:
    """Return 32 random bits in six characters: short, because every command quotes a beat.

    At 100 messages a second a page guesses a valid beat about once in 50 days.
    """
    return secrets.token_urlsafe(4)


class Beats:
    """The beats that were sent to one page, in seconds on the server's clock."""

    def __init__(self, word: Callable[[], str] = _random) -> None:
        self._word = word
        self._sent_s = BoundedDict[str, float](_KEPT)
        self._newest_s = -math.inf

    def send(self, now_s: float) -> str:
        """Return a new beat and record that it is sent now."""
        word = self._word()
        self._sent_s[word] = self._newest_s = now_s
        return word

    def is_due(self, now_s: float, *, is_thin: bool) -> bool:
        """Whether a page that sends commands is due another beat."""
        return now_s - self._newest_s >= (THIN_EVERY_S if is_thin else EVERY_S)

    def sent_s(self, word: str | None) -> float:
        """Return when this beat was sent, minus infinity if it is unknown or expired."""
        return -math.inf if word is None else self._sent_s.get(word, -math.inf)
