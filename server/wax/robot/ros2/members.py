"""Type checks for the members of a message, since JSON may contain anything (pure)."""

from __future__ import annotations


def text(value: object) -> str:
    """Return a text; raises `TypeError` for anything else, which may be nested without end."""
    if not isinstance(value, str):
        raise TypeError("not a text")
    return value


def whole(value: object) -> int:
    """Return a whole number; raises `TypeError` for anything else."""
    if not isinstance(value, int):
        raise TypeError("no whole number")
    return value


def number(value: object) -> float:
    """Return a number; raises `TypeError` for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError("no number")
    return value
