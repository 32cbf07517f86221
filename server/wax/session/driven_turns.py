"""Who has driven the newest turns, and what they may still say about the recording. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from wax.bounded_dict import BoundedDict

DISOWN_S: Final = 120.0
_MOST: Final = 1000


@dataclass(slots=True)
class _Driven:
    operator: int
    began_s: float
    ended_s: float | None = None
    task: str = ""


class DrivenTurns:
    """The turns by their numbers, which rise."""

    def __init__(self) -> None:
        self._turns = BoundedDict[int, _Driven](_MOST)

    def began(self, turn: int, operator: int, now_s: float) -> None:
        self._turns[turn] = _Driven(operator, now_s)

    def ended(self, turn: int, now_s: float) -> None:
        if turn in self._turns:
            self._turns[turn].ended_s = now_s

    def set_task(self, viewer: int, turn: int, text: str) -> bool:
        """Whether this text is new, and from the viewer who drives this turn now."""
        driven = self._turns.get(turn)
        if driven is None or driven.operator != viewer or driven.ended_s is not None:
            return False
        is_new, driven.task = text != driven.task, text
        return is_new

    def disown(self, viewer: int, turn: int, now_s: float) -> tuple[float, float] | None:
        """Return when the turn was, once; None for others, and `DISOWN_S` after its end."""
        driven = self._turns.get(turn)
        if driven is None or driven.operator != viewer or driven.ended_s is None:
            return None
        if now_s - driven.ended_s > DISOWN_S:
            return None
        del self._turns[turn]
        return driven.began_s, driven.ended_s
