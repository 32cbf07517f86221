"""What of the tape goes, to stay within its size and days; `recorder` sees a full disk. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Sequence

Keeper = Literal["host", "operator", "fault"]
"""By whom, or by what, a part is kept. What the host keeps only a person deletes; the others' is
kept longer than the rest as long as there is room, so that nobody can fill the tape for good."""


@dataclass(frozen=True, slots=True)
class Part:
    """One part of the tape: its size, and when it ended in seconds since 1970."""

    name: str
    ended_s: float
    size_bytes: int
    kept: Keeper | None = None
    is_open: bool = False
    """Whether it is being written now."""


@dataclass(frozen=True, slots=True)
class Retention:
    """The names of what goes, and how much is left after that."""

    gone: tuple[str, ...]
    left_bytes: int


def retain(parts: Sequence[Part], *, now_s: float, max_bytes: float, keep_days: float) -> Retention:
    """Choose what goes of `parts`, of which the oldest is first.

    Whatever is older than its days goes; beyond the size the oldest that nobody keeps, and then the
    oldest that is kept, but never what the host keeps or what is being written.
    """
    free = [one for one in parts if one.kept != "host" and not one.is_open]
    left_bytes = sum(one.size_bytes for one in parts)
    gone: list[str] = []
    in_order = [*(one for one in free if one.kept is None), *(one for one in free if one.kept)]
    for one in in_order:
        is_old = now_s - one.ended_s > keep_days * 86_400
        if is_old or left_bytes > max_bytes:
            gone.append(one.name)
            left_bytes -= one.size_bytes
    return Retention(tuple(gone), left_bytes)
