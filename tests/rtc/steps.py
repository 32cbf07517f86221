"""Counts the instructions that Python executes: a measure of work that is equal on all machines."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType


@dataclass
class Steps:
    count: int = 0


@contextmanager
def counted() -> Iterator[Steps]:
    """Count instructions inside, calls included; C's own loops are not seen."""
    steps = Steps()

    def trace(frame: FrameType, event: str, _what: object) -> Any:
        frame.f_trace_opcodes = True
        steps.count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield steps
    finally:
        sys.settrace(before)
