"""What an input costs, in steps of the interpreter: the same at each run, on any machine."""

from __future__ import annotations

import gc
import sys
from threading import get_ident
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType, FrameType

_TOOL: Final = 4
"""Of `sys.monitoring`; coverage, profilers and debuggers have others."""


def steps(work: Callable[[], None]) -> int:
    """Return how many instructions of Python it takes; what C does in one of them is not seen."""
    was_collecting = gc.isenabled()
    gc.disable()  # what it would finalise is others'
    try:
        return _count(work)
    finally:
        if was_collecting:
            gc.enable()


# Since Python 3.12 a tracer sees the instructions of the frames alone that it knew when it began.
if sys.version_info >= (3, 12):

    def _count(work: Callable[[], None]) -> int:
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

    def _count(work: Callable[[], None]) -> int:
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
