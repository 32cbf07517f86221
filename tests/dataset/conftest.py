"""What the tests of both exports have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def tape(tmp_path: Path) -> Shelf:
    """Return the folder of an empty tape."""
    made = Shelf(tmp_path / "tape")
    made.prepare()
    return made
