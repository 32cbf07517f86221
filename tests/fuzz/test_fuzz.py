"""Bytes from outside: a value or the declared error, never anything else, and no motion."""

from __future__ import annotations

import os
from random import Random, SystemRandom
from typing import TYPE_CHECKING

import pytest
from tests.fuzz.mutator import Mutator
from tests.fuzz.plan import TARGETS
from tests.fuzz.target import CORPUS, quiet

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with quiet():
        yield


@pytest.mark.parametrize("name", TARGETS)
def test_what_is_valid_is_understood(name: str) -> None:
    """The inputs from which all others are made pass."""
    for seed in TARGETS[name].seeds:
        TARGETS[name].try_one(seed)


@pytest.mark.parametrize(
    ("name", "path"), [(name, path) for name, one in TARGETS.items() for path in one.corpus()]
)
def test_what_once_failed_does_so_no_more(name: str, path: Path) -> None:
    """Every stored input is a value or a refusal."""
    TARGETS[name].try_one(path.read_bytes())


def test_every_stored_input_is_replayed() -> None:
    """No folder of the corpus belongs to a target that is gone."""
    assert {path.name for path in CORPUS.iterdir()} <= set(TARGETS)


@pytest.mark.system
@pytest.mark.parametrize("share", [0.25, pytest.param(1.0, marks=pytest.mark.full)])
@pytest.mark.parametrize("name", TARGETS)
def test_any_bytes_are_a_value_or_a_refusal(name: str, share: float) -> None:
    """Thousands of inputs near valid ones, others each time, in CI the same."""
    target = TARGETS[name]
    seed = 1 if os.environ.get("CI") else SystemRandom().getrandbits(32)
    mutator = Mutator(Random(seed), target.seeds, target.words, target.max_bytes)
    for _ in range(int(share * target.inputs)):
        data = mutator.draw()
        try:
            target.try_one(data)
        except Exception as error:
            error.add_note(f"{name} of seed {seed}, to be stored in {target.folder}: {data!r}")
            raise
