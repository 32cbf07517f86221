"""Keeps logs short and readable, whatever strangers make the server log."""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING, Any, Final

from wax.logs.printable import printable
from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, MutableMapping

_MAX_CHARS: Final = 300
_MAX_TRACE_CHARS: Final = 8000
_BURST: Final = 100
_RATE_HZ: Final = 1.0
_MAX_KINDS: Final = 1000
_LEFT_OUT: Final = "left_out"
_TRACES: Final = frozenset(("exc_info", "exception", "stack", "stack_info"))


class RepeatLimit(logging.Filter):
    """A rate limit: a burst of a hundred lines of one kind, then one a second.

    A kind is an event of ours, or a line of a library's code. The next line let through says how
    many were left out, and has no traceback, since a hundred had one. It is safe in any thread: the
    worst of a race is a line too many.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._now_s = now_s
        self._kinds: dict[Hashable, tuple[TokenBucket, int]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        kind = _kind(record)
        if len(self._kinds) >= _MAX_KINDS:
            self._kinds.clear()
        bucket, left_out = self._kinds.get(kind) or (TokenBucket(_RATE_HZ, _BURST), 0)
        passes = bucket.take(self._now_s())
        self._kinds[kind] = bucket, 0 if passes else left_out + 1
        if passes and left_out:
            setattr(record, _LEFT_OUT, left_out)
            _drop_trace(record)
        return passes


def add_left_out(_: object, __: str, event: MutableMapping[str, Any]) -> MutableMapping[str, Any]:
    """Add to a line how many of its kind were left out (structlog processor)."""
    left_out = getattr(event.get("_record"), _LEFT_OUT, 0)
    if left_out:
        event[_LEFT_OUT] = left_out
    return event


def tidy(_: object, __: str, event: MutableMapping[str, Any]) -> MutableMapping[str, Any]:
    """Bound each value and escape hidden characters (structlog processor, before the renderer)."""
    for name, value in event.items():
        if name in ("exception", "stack") and isinstance(value, str):
            event[name] = _tidy_trace(value)
        elif value is not None and not isinstance(value, bool | int | float):
            text = value if isinstance(value, str) else repr(value)
            event[name] = printable(text, _MAX_CHARS)
    return event


def _tidy_trace(trace: str) -> str:
    """Keep a traceback's lines; of a long one keep the end, which names the error."""
    lines = [printable(line, _MAX_CHARS) for line in trace[-_MAX_TRACE_CHARS:].split("\n")]
    return "\n".join(lines)


def _drop_trace(record: logging.LogRecord) -> None:
    record.exc_info = record.exc_text = record.stack_info = None
    if isinstance(record.msg, dict):
        record.msg = {key: value for key, value in record.msg.items() if key not in _TRACES}


def _kind(record: logging.LogRecord) -> Hashable:
    if isinstance(record.msg, dict):
        return record.name, record.msg.get("event")
    return record.name, record.lineno
