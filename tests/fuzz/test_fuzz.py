"""Bytes from outside: a value or the declared error, never anything else, and no motion."""

from __future__ import annotations

import os
from random import Random, SystemRandom
from typing import TYPE_CHECKING

import pytest
from tests.examples import share_of
from tests.fuzz.mutator import Mutator
from tests.fuzz.plan import TARGETS
from tests.fuzz.target import CORPUS, Target, quiet
from tests.turned_clock import TurnedClock

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with quiet():
        yield


@pytest.mark.parametrize("name", TARGETS)
def test_what_is_valid_is_understood(name: str) -> None:
    """The inputs from which all others are made are accepted."""
    for seed in TARGETS[name].seeds:
        TARGETS[name].try_one(seed)


@pytest.mark.parametrize(
    ("name", "path"), [(name, path) for name, one in TARGETS.items() for path in one.corpus()]
)
def test_what_once_failed_does_so_no_more(name: str, path: Path) -> None:
    """Every stored input gives a value or a refusal."""
    TARGETS[name].try_one(path.read_bytes())


def test_every_stored_input_is_replayed() -> None:
    """No folder of the corpus belongs to a target that is gone."""
    assert {path.name for path in CORPUS.iterdir()} <= set(TARGETS)


@pytest.mark.parametrize("name", TARGETS)
def test_no_input_costs_more_than_its_length_may(name: str) -> None:
    """Stored inputs, valid ones and some near them cost at most so many steps a byte."""
    target = TARGETS[name]
    mutator = Mutator(Random(1), target.seeds, target.words, target.max_bytes)
    inputs = [*target.seeds, *(path.read_bytes() for path in target.corpus())]
    for data in (*inputs, *(mutator.draw() for _ in range(share_of(20)))):
        target.count(data)


@pytest.mark.parametrize(
    "hear",
    [
        lambda data: [None for _ in range(int.from_bytes(data[:2], "big"))],
        lambda data: [None for _ in data.strip(b"\0") for _ in data],
    ],
    ids=["announces", "squares"],
)
def test_what_costs_more_is_found(hear: Callable[[bytes], None]) -> None:
    """Work in proportion to an announced number, or to the square of the length, fails."""
    target = Target(name="dear", what="dear inputs", hear=hear, seeds=())
    target.count(bytes(500))
    with pytest.raises(AssertionError, match=r"steps for 500 bytes"):
        target.count(b"\xff" * 500)


def test_what_takes_its_time_in_c_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search also looks at processor time, at the least of several tries."""
    clock, took_s = TurnedClock(), [0.5]

    def hear(_: bytes) -> None:
        clock.time_s += took_s.pop() if len(took_s) > 1 else took_s[0]

    monkeypatch.setattr("time.thread_time", clock.now_s)
    target = Target(name="slow", what="slow inputs", hear=hear, seeds=())
    with pytest.raises(AssertionError, match="500 ms for 10 bytes"):
        target.try_cost(bytes(10))
    took_s[:] = [0.001, 0.5, 0.5, 0.5]  # others had the processor
    target.try_cost(bytes(10))


@pytest.mark.system
@pytest.mark.timeout(300)  # it computes all the time
@pytest.mark.parametrize("name", TARGETS)
def test_any_bytes_are_a_value_or_a_refusal(name: str) -> None:
    """Mutated inputs give a value or a refusal; they differ each time, but not in CI."""
    target = TARGETS[name]
    seed = 1 if os.environ.get("CI") else SystemRandom().getrandbits(32)
    mutator = Mutator(Random(seed), target.seeds, target.words, target.max_bytes)
    for _ in range(share_of(target.inputs)):
        data = mutator.draw()
        try:
            target.try_one(data)
        except Exception as error:
            error.add_note(f"{name} of seed {seed}, to be stored in {target.folder}: {data!r}")
            raise
