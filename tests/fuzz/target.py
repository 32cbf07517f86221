"""What is fuzzed: a function that takes any bytes, and inputs to begin with."""

from __future__ import annotations

import logging
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import structlog

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator, Sequence

CORPUS: Final = Path(__file__).parent / "corpus"
"""A folder for each target, with inputs that once failed or that no mutation finds soon."""

SLOW_S: Final = 1.0
"""Processor time. The longest legal input takes a hundredth; the control loop waits meanwhile."""

_PASSES: Final = 8


@dataclass(frozen=True, slots=True)
class Target:
    """`hear` takes any bytes and raises only what is a defect; `what` says it for people.

    `seeds` are valid inputs, `words` what a mutator puts in; both lead it past the first checks.
    `long_seeds` take too much time for a test, which tries so many `inputs`.
    """

    name: str
    what: str
    hear: Callable[[bytes], None]
    seeds: Sequence[bytes]
    words: Sequence[bytes] = ()
    max_bytes: int = 2048
    long_seeds: Sequence[bytes] = ()
    inputs: int = 10_000

    @property
    def folder(self) -> Path:
        return CORPUS / self.name

    def corpus(self) -> list[Path]:
        """Return the stored inputs, in order."""
        return sorted(self.folder.glob("*")) if self.folder.is_dir() else []

    def try_one(self, data: bytes) -> None:
        """Hear it; raises `AssertionError` too where that takes too long."""
        began_s = time.thread_time()
        self.hear(data)
        took_s = time.thread_time() - began_s
        assert took_s < SLOW_S, f"{took_s:.1f} s of processor time for {len(data)} bytes"


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
