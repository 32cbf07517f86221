"""The cost of an input in interpreter steps: the same in each run, on any machine."""

from __future__ import annotations

import gc
import sys
from threading import get_ident
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType, FrameType

_TOOL: Final = 4
"""An id for `sys.monitoring` that coverage, profilers and debuggers do not use."""


def steps(work: Callable[[], object]) -> int:
    """Return how many Python instructions the work takes; C code inside one is not counted."""
    was_collecting = gc.isenabled()
    gc.disable()  # its finalisers would run other tests' code
    try:
        return _count(work)
    finally:
        if was_collecting:
            gc.enable()


# Since Python 3.12 a tracer sees only the instructions of frames that existed when it began.
if sys.version_info >= (3, 12):

    def _count(work: Callable[[], object]) -> int:
        counted, here, monitoring = 0, get_ident(), sys.monitoring
        kind = monitoring.events.INSTRUCTION

        def count(_code: CodeType, _offset: int) -> None:
            nonlocal counted
            counted += get_ident() == here

        monitoring.use_tool_id(_TOOL, __name__)
        monitoring.register_callback(_TOOL, kind, count)
        try:
            monitoring.set_events(_TOOL, kind)
            work()
        finally:
            monitoring.set_events(_TOOL, monitoring.events.NO_EVENTS)
            monitoring.register_callback(_TOOL, kind, None)
            monitoring.free_tool_id(_TOOL)
        return counted

else:

    def _count(work: Callable[[], object]) -> int:
        counted = 0

        def count(_frame: FrameType, event: str, _argument: Any) -> Any:
            nonlocal counted
            counted += event == "opcode"
            return count

        def enter(frame: FrameType, _event: str, _argument: Any) -> Any:
            frame.f_trace_opcodes, frame.f_trace_lines = True, False
            return count

        before = sys.gettrace()
        sys.settrace(enter)
        try:
            work()
        finally:
            sys.settrace(before)
        return counted
