"""What is fuzzed: a function that takes any bytes, and inputs to begin with."""

from __future__ import annotations

import logging
import time
from contextlib import contextmanager
from dataclasses import dataclass
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
"""What each byte may cost, in steps of `cost.py`; about 3 µs, so that somebody's megabit a second
takes less than half of a core, before any limit of theirs."""

_FAST_STEP_S: Final = 10e-9
_SLOW_STEP_S: Final = 200e-9
"""A step takes 25 ns; what takes less than the former is not dear, and what takes more than the
latter at each of some tries is, although C does it in few."""

_TRIES: Final = 5
_INFLATED: Final = 3
"""What counts the branches that an input takes makes one step two or three."""

_PASSES: Final = 8


@dataclass(frozen=True, slots=True)
class Target:
    """`hear` takes any bytes and raises only what is a defect; `what` says it for people.

    `seeds` are valid inputs, `words` what a mutator puts in; both lead it past the first checks.
    `long_seeds` take too much time for a test, which tries so many `inputs`. An input may cost
    `STEPS_A_BYTE` and, whatever its length, so many `steps`, mostly for the scene that hears it.
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

    @property
    def folder(self) -> Path:
        return CORPUS / self.name

    def corpus(self) -> list[Path]:
        """Return the stored inputs, in order."""
        return sorted(self.folder.glob("*")) if self.folder.is_dir() else []

    def try_one(self, data: bytes) -> float:
        """Hear it; returns the seconds that it took, and raises `AssertionError` if too many."""
        began_s = time.thread_time()
        self.hear(data)
        took_s = time.thread_time() - began_s
        assert took_s < SLOW_S, f"{took_s:.1f} s of processor time for {len(data)} bytes"
        return took_s

    def count(self, data: bytes, *, inflated: int = 1) -> None:
        """Raise `AssertionError` where hearing it takes more steps than its length may."""
        self.hear(data)  # what is made once for all is not its cost
        most, counted = inflated * self._most_steps(data), steps(lambda: self.hear(data))
        assert counted <= most, f"{counted} steps for {len(data)} bytes, which may take {most}"

    def try_cost(self, data: bytes) -> None:
        """Hear it, and look closer where that is not quick; raises `AssertionError` as both do.

        In the search, whose instruments take steps and time as well.
        """
        most = _INFLATED * self._most_steps(data)
        if self.try_one(data) < most * _FAST_STEP_S:
            return
        self.count(data, inflated=_INFLATED)
        took_s = min(self.try_one(data) for _ in range(_TRIES))
        assert took_s < most * _SLOW_STEP_S, f"{took_s * 1000:.0f} ms for {len(data)} bytes"

    def _most_steps(self, data: bytes) -> int:
        return self.steps + STEPS_A_BYTE * len(data)


@contextmanager
def quiet() -> Iterator[None]:
    """Log nothing inside the block: refusals are what is asked for here."""
    before = structlog.get_config()
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    try:
        yield
    finally:
        structlog.configure(**before)


def at_once(work: Coroutine[Any, Any, Any]) -> Any:
    """Return the result of a coroutine that at most lets others go first, without a loop."""
    try:
        for _ in range(_PASSES):
            assert work.send(None) is None, "it waits for something"
    except StopIteration as done:
        return done.value
    raise AssertionError("it does not end")
