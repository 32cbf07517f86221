"""Decides which parts to delete for the tape's size and age; `recorder` watches the disk. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Sequence

Keeper = Literal["host", "operator", "fault"]
"""Who or what keeps a part. Only a person deletes what the host keeps. What others keep outlasts
unkept parts only while there is room, so that nobody can fill the tape permanently."""


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
    """The names of the parts to delete, and the size of the rest."""

    gone: tuple[str, ...]
    left_bytes: int


def retain(parts: Sequence[Part], *, now_s: float, max_bytes: float, keep_days: float) -> Retention:
    """Choose which of `parts`, the oldest first, to delete.

    Parts older than `keep_days` go. If the rest is too large, the oldest unkept parts go, then the
    oldest kept ones; but never one that the host keeps or that is being written.
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
