"""A fuzz target: a function that takes any bytes, and inputs to start with."""

from __future__ import annotations

import logging
import time
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import structlog
from tests.fuzz.cost import steps

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator, Sequence

CORPUS: Final = Path(__file__).parent / "corpus"
"""A folder for each target, with inputs that once failed or that no mutation finds soon."""

SLOW_S: Final = 1.0
"""Processor time. The longest legal input takes a hundredth; the control loop waits meanwhile."""

STEPS_A_BYTE: Final = 100
"""The most that each byte may cost, in steps of `cost.py`; about 3 µs, so that a stranger's megabit
a second takes less than half of a core, before any limit applies."""

_FAST_STEP_S: Final = 10e-9
_SLOW_STEP_S: Final = 200e-9
"""A step takes 25 ns. An input quicker than the former for each allowed step needs no count; one
slower than the latter in each of several tries is too expensive, even if C does it in few steps."""

_TRIES: Final = 5
_INFLATED: Final = 3
"""Counting the branches that an input takes makes one step two or three."""

_PASSES: Final = 8


@dataclass(frozen=True, slots=True)
class Target:
    """`hear` takes any bytes and raises only for a defect; `what` describes it for people.

    `seeds` are valid inputs, `words` what a mutator inserts; both lead past the first checks.
    `long_seeds` take too much time for a test, which tries so many `inputs`. An input may cost
    `STEPS_A_BYTE` per byte, and in addition this many `steps`, mostly for setting up the target.
    What `scene` takes, which `hear` makes anew for each valid input, is not the input's cost.
    """

    name: str
    what: str
    hear: Callable[[bytes], None]
    seeds: Sequence[bytes]
    words: Sequence[bytes] = ()
    max_bytes: int = 2048
    long_seeds: Sequence[bytes] = ()
    inputs: int = 10_000
    steps: int = 30_000
    scene: Callable[[], object] | None = None

    @property
    def folder(self) -> Path:
        return CORPUS / self.name

    def corpus(self) -> list[Path]:
        """Return the stored inputs, in order."""
        return sorted(self.folder.glob("*")) if self.folder.is_dir() else []

    def try_one(self, data: bytes) -> float:
        """Try one input; return the seconds it took, or raise `AssertionError` if too many."""
        began_s = time.thread_time()
        self.hear(data)
        took_s = time.thread_time() - began_s
        assert took_s < SLOW_S, f"{took_s:.1f} s of processor time for {len(data)} bytes"
        return took_s

    def count(self, data: bytes, *, inflated: int = 1) -> None:
        """Raise `AssertionError` if the input takes more steps than its length allows."""
        self.hear(data)  # what is made once for all inputs is not its cost
        most, counted = inflated * self._most_steps(data), steps(lambda: self.hear(data))
        assert counted <= most, f"{counted} steps for {len(data)} bytes, which may take {most}"

    def try_cost(self, data: bytes) -> None:
        """Try one input, and count its steps if it is slow; raises `AssertionError` as both do.

        For the search, whose instruments also take steps and time.
        """
        most = _INFLATED * self._most_steps(data)
        if self.try_one(data) < most * _FAST_STEP_S:
            return
        self.count(data, inflated=_INFLATED)
        took_s = min(self.try_one(data) for _ in range(_TRIES))
        assert took_s < most * _SLOW_STEP_S, f"{took_s * 1000:.0f} ms for {len(data)} bytes"

    def _most_steps(self, data: bytes) -> int:
        made = 0 if self.scene is None else _steps_of(self.scene)
        return made + self.steps + STEPS_A_BYTE * len(data)


@cache
def _steps_of(scene: Callable[[], object]) -> int:
    scene()  # what is made once for all is not counted
    return steps(scene)


@contextmanager
def quiet() -> Iterator[None]:
    """Log nothing inside the block: refusals are expected here."""
    before = structlog.get_config()
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    try:
        yield
    finally:
        structlog.configure(**before)


def at_once(work: Coroutine[Any, Any, Any]) -> Any:
    """Return the result of a coroutine that only yields to others, without an event loop."""
    try:
        for _ in range(_PASSES):
            assert work.send(None) is None, "it waits for something"
    except StopIteration as done:
        return done.value
    raise AssertionError("it does not end")
