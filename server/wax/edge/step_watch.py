"""Which steps of the event loop are long, and what they belong to.

A step is what asyncio runs without looking at anything else: a callback, or a task up to its next
wait. Whatever else is due then, a command or somebody's Stop, waits for its end.
"""

from __future__ import annotations

import asyncio
import sys
import threading
import time
from collections import Counter, deque
from functools import partial
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final, Self

import structlog

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType, FrameType

_LOG = structlog.get_logger(__name__)

LONG_S: Final = 0.002
LONG_STEP: Final = "a step of the event loop was long"
_LONG_WAIT: Final = "a step of the event loop waited for a device, a lock or other programs"
_NEVER_S: Final = float("inf")
_MOST_PARTS: Final = 100
"""As many series of a metric; there are fewer callbacks and coroutines that can be long."""


class StepWatch:
    """Times each step of one event loop: `ready` is its queue, `rests` is due before it waits.

    That costs a third of a microsecond a step. Nothing is counted before `begin`.
    """

    def __init__(self, now_s: Callable[[], float] = time.perf_counter) -> None:
        self.ready = _Ready(self, now_s)
        self.now_s = now_s
        self._has_begun = False
        self.counts = Counter[str]()
        """How many long steps there were, by part."""
        self.longest_s: dict[str, float] = {}
        self._stacks: StackSampler | None = None

    def begin(self) -> None:
        """Count from here on: nobody drives yet while everything is loaded and opened."""
        self._has_begun = True
        self.ready.began_s = self.now_s()

    def status(self) -> dict[str, dict[str, float]]:
        """Return the number of long steps and the longest of them, by part."""
        return {
            part: {"count": count, "longest_ms": round(self.longest_s[part] * 1000, 1)}
            for part, count in self.counts.items()
        }

    def rests(self) -> None:
        """Note that the last step has ended."""
        ready = self.ready
        lasted_s = self.now_s() - ready.began_s
        if lasted_s > LONG_S:
            self.was_long(ready.callback, lasted_s)
        ready.began_s = _NEVER_S

    def was_long(self, callback: object, lasted_s: float) -> None:
        if not self._has_begun or callback is None:
            return
        part = part_of(callback)
        if part not in self.counts and len(self.counts) >= _MOST_PARTS:
            part = "others"
        self.counts[part] += 1
        self.longest_s[part] = max(self.longest_s.get(part, 0.0), lasted_s)
        if self._stacks is not None:
            self._stacks.tell(part, lasted_s)

    def sample(self, stacks: StackSampler | None) -> None:
        """Have each long step told to `stacks` from now on; None ends that."""
        self._stacks = stacks
        self.ready.is_sampled = stacks is not None


class _Ready(deque[asyncio.Handle]):
    """asyncio's queue of steps: each begins when it is taken out, and ends with the next."""

    __slots__ = ("_now_s", "_watch", "began_s", "callback", "is_sampled", "used_s")

    def __init__(self, watch: StepWatch, now_s: Callable[[], float]) -> None:
        super().__init__()
        self._watch = watch
        self._now_s = now_s
        self.began_s = _NEVER_S
        self.callback: object = None
        """Of the step that runs, whose handle forgets it where it ends itself, as a read does."""
        self.is_sampled = False
        self.used_s = 0.0

    def popleft(self, _take: Callable[[Any], asyncio.Handle] = deque.popleft) -> asyncio.Handle:
        now_s = self._now_s()
        if now_s - self.began_s > LONG_S:
            self._watch.was_long(self.callback, now_s - self.began_s)
            now_s = self._now_s()
        self.began_s = now_s
        if self.is_sampled:  # it takes longer than all the rest here
            self.used_s = time.thread_time()
        handle = _take(self)
        self.callback = handle._callback  # type: ignore[attr-defined]
        return handle


class StackSampler:
    """Logs each long step with its stack, while open; for one who looks, as it costs some percent.

    The stack is the one that it was found in most often, each millisecond. Where the processor's
    time is much shorter than the step, it waited, as for other programs.
    """

    def __init__(self, watch: StepWatch) -> None:
        """Call in the thread of the event loop."""
        self._watch = watch
        self._loop_thread = threading.get_ident()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stacks", daemon=True)
        self._seen: tuple[float, Counter[str]] = (_NEVER_S, Counter())
        self._switch_s = sys.getswitchinterval()

    def __enter__(self) -> Self:
        # Python lets another thread in no sooner than that, and most long steps are over by then.
        sys.setswitchinterval(LONG_S / 4)
        self._watch.sample(self)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._watch.sample(None)
        self._ended.set()
        self._thread.join()
        sys.setswitchinterval(self._switch_s)

    def _run(self) -> None:
        while not self._ended.wait(LONG_S / 2):
            self.look()

    def look(self) -> None:
        """Take the stack of a step that may become a long one."""
        began_s = self._watch.ready.began_s
        if self._watch.now_s() - began_s < LONG_S / 2:
            return
        stack = _stack(sys._current_frames().get(self._loop_thread))
        if self._seen[0] != began_s:
            self._seen = (began_s, Counter())
        self._seen[1][stack] += 1

    def tell(self, part: str, lasted_s: float) -> None:
        """Log the step that has just ended."""
        began_s, stacks = self._seen
        # A copy is made in one step; the other thread may add to the original meanwhile.
        seen = dict(stacks) if began_s == self._watch.ready.began_s else {}
        used_s = time.thread_time() - self._watch.ready.used_s
        _LOG.warning(
            LONG_STEP if used_s > LONG_S else _LONG_WAIT,
            part=part,
            ms=round(lasted_s * 1000, 1),
            processor_ms=round(used_s * 1000, 1),
            stack=max(seen, key=lambda stack: seen[stack], default=""),
        )


def part_of(callback: Any) -> str:
    """Return the coroutine, the protocol or the callback of a step, in its module; no content.

    Never raises, which would end the event loop.
    """
    while isinstance(callback, partial):
        callback = callback.func
    owner = getattr(callback, "__self__", None)
    if isinstance(owner, asyncio.Task):
        callback = owner.get_coro()
    elif isinstance(owner, asyncio.BaseTransport):
        callback = type(getattr(owner, "_protocol", None))
    code = getattr(callback, "__code__", None) or getattr(callback, "cr_code", None)
    name = getattr(callback, "__qualname__", type(callback).__qualname__)
    return f"{_module(code) if code else getattr(callback, '__module__', '')}.{name}"


def _module(code: CodeType) -> str:
    path = PurePath(code.co_filename)
    return f"{path.parent.name}.{path.stem}"


def _stack(frame: FrameType | None) -> str:
    """Return file, line and function of each call below the event loop, the outermost first."""
    lines: list[str] = []
    while frame is not None and frame.f_code.co_qualname != "Handle._run":
        code = frame.f_code
        lines.append(f"{_module(code)}:{frame.f_lineno} {code.co_qualname}")
        frame = frame.f_back
    return "\n".join(reversed(lines))
