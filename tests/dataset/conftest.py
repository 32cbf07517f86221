"""What the tests of both exports have in common."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(autouse=True)
def _unhurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave this process's priority as it is."""
    monkeypatch.setattr(os, "nice", lambda _: 0)
    monkeypatch.setattr(os, "sched_setscheduler", lambda *_: None, raising=False)


@pytest.fixture
def tape(tmp_path: Path) -> Shelf:
    """Return the folder of an empty tape."""
    made = Shelf(tmp_path / "tape")
    made.prepare()
    return made
