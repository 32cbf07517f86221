"""Counts the long steps of the event loop, by the part of the program that they belong to.

A step is what asyncio runs without a break: a callback, or a task up to its next wait. Whatever
falls due meanwhile, such as a command or a Stop, waits for its end.
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
"""Bounds the series of a metric; fewer callbacks and coroutines than that can be long."""


class StepWatch:
    """Times each step of an event loop with `ready` as its queue and `end_step` before each wait.

    This costs a third of a microsecond per step. Nothing is counted before `start_counting`.
    """

    def __init__(self, now_s: Callable[[], float] = time.perf_counter) -> None:
        self.ready = _Ready(self, now_s)
        self.now_s = now_s
        self._is_counting = False
        self.counts = Counter[str]()
        """The number of long steps, by part."""
        self.longest_s: dict[str, float] = {}
        self._stacks: StackSampler | None = None

    def start_counting(self) -> None:
        """Start counting: while everything is still loaded and opened, nobody drives."""
        self._is_counting = True
        self.ready.began_s = self.now_s()

    def status(self) -> dict[str, dict[str, float]]:
        """Return the number of long steps and the longest of them, by part."""
        return {
            part: {"count": count, "longest_ms": round(self.longest_s[part] * 1000, 1)}
            for part, count in self.counts.items()
        }

    def end_step(self) -> None:
        """Note that the last step has ended: the loop waits next."""
        ready = self.ready
        lasted_s = self.now_s() - ready.began_s
        if lasted_s > LONG_S:
            self.count_long(ready.callback, lasted_s)
        ready.began_s = _NEVER_S

    def count_long(self, callback: object, lasted_s: float) -> None:
        if not self._is_counting or callback is None:
            return
        part = part_of(callback)
        if part not in self.counts and len(self.counts) >= _MOST_PARTS:
            part = "others"
        self.counts[part] += 1
        self.longest_s[part] = max(self.longest_s.get(part, 0.0), lasted_s)
        if self._stacks is not None:
            self._stacks.log_step(part, lasted_s)

    def sample(self, stacks: StackSampler | None) -> None:
        """Let `stacks` log each long step from now on; None ends that."""
        self._stacks = stacks
        self.ready.is_sampled = stacks is not None


class _Ready(deque[asyncio.Handle]):
    """asyncio's queue of steps: each begins when it is popped, and ends when the next is."""

    __slots__ = ("_now_s", "_watch", "began_s", "callback", "is_sampled", "used_s")

    def __init__(self, watch: StepWatch, now_s: Callable[[], float]) -> None:
        super().__init__()
        self._watch = watch
        self._now_s = now_s
        self.began_s = _NEVER_S
        self.callback: object = None
        """The running step's; its handle forgets it if the step cancels itself, as a read may."""
        self.is_sampled = False
        self.used_s = 0.0

    def popleft(self, _take: Callable[[Any], asyncio.Handle] = deque.popleft) -> asyncio.Handle:
        now_s = self._now_s()
        if now_s - self.began_s > LONG_S:
            self._watch.count_long(self.callback, now_s - self.began_s)
            now_s = self._now_s()
        self.began_s = now_s
        if self.is_sampled:  # `thread_time` takes longer than the rest of this method
            self.used_s = time.thread_time()
        handle = _take(self)
        self.callback = handle._callback  # type: ignore[attr-defined]
        return handle


class StackSampler:
    """Logs each long step with its stack, while open; for debugging, since it costs some percent.

    It samples each millisecond, and logs the most frequent stack. A step whose processor time is
    much shorter than the step has waited, for example for other programs.
    """

    def __init__(self, watch: StepWatch) -> None:
        """Call it in the event loop's thread."""
        self._watch = watch
        self._loop_thread = threading.get_ident()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stacks", daemon=True)
        self._seen: tuple[float, Counter[str]] = (_NEVER_S, Counter())
        self._switch_s = sys.getswitchinterval()

    def __enter__(self) -> Self:
        # By default Python switches threads after 5 ms, when most long steps are over.
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
            self.sample_stack()

    def sample_stack(self) -> None:
        """Sample the stack of the running step, if it may become a long one."""
        began_s = self._watch.ready.began_s
        if self._watch.now_s() - began_s < LONG_S / 2:
            return
        stack = _stack(sys._current_frames().get(self._loop_thread))
        if self._seen[0] != began_s:
            self._seen = (began_s, Counter())
        self._seen[1][stack] += 1

    def log_step(self, part: str, lasted_s: float) -> None:
        """Log the step that has just ended."""
        began_s, stacks = self._seen
        # The copy is atomic; the sampler's thread may change the original at any time.
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
    """Return the name of a step's coroutine, protocol or callback, with its module; no values.

    It never raises: that would end the event loop.
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
