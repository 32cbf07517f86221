"""Which parts of the tape an export reads."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from wax.errors import ConfigError, StateError
from wax.tape.selection import select
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from pathlib import Path

NAMES = ["wax-20261123T140000Z", "wax-20261123T140100Z", "wax-20261123T140200Z"]
FIRST_S = 1_795_442_400.0


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    """Three parts of a minute; the host keeps the second."""
    made = Shelf(tmp_path)
    for number, name in enumerate(NAMES):
        path = made.path(name, ".mcap")
        path.write_bytes(b"")
        ended_s = FIRST_S + 60 * (number + 1)
        os.utime(path, (ended_s, ended_s))
    made.keep(NAMES[1], "host")
    return made


@pytest.mark.parametrize(
    ("asked", "numbers"),
    [
        ({}, [0, 1, 2]),
        ({"begin": "2026-11-23T14:01:30"}, [1, 2]),
        ({"end": "2026-11-23T14:01:30"}, [0, 1]),
        ({"begin": "2026-11-23T14:00:30", "end": "2026-11-23T15:00:40+01:00"}, [0]),
        ({"kept": True}, [1]),
    ],
)
def test_parts_are_selected_by_time_and_by_who_keeps_them(
    shelf: Shelf, asked: dict[str, str], numbers: list[int]
) -> None:
    """A part counts if any of it lies within the time; `kept` leaves out what nobody keeps."""
    found = select(shelf, **asked)  # type: ignore[arg-type]
    assert [one.name for one in found.parts] == [NAMES[n] for n in numbers]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"end": "2026-11-22"}, "nothing is recorded at that time"),
        ({"begin": "2026-11-23T14:02:10", "kept": True}, "nothing is kept at that time"),
    ],
)
def test_an_empty_selection_is_said(shelf: Shelf, asked: dict[str, str], said: str) -> None:
    """Without a part there is nothing to export, and the sentence says where to look."""
    with pytest.raises(StateError, match=said):
        select(shelf, **asked)  # type: ignore[arg-type]


def test_a_time_that_ends_before_it_begins_is_refused(shelf: Shelf) -> None:
    """Two dates in the wrong order are wrong usage."""
    with pytest.raises(ConfigError, match="--from must be earlier than --to"):
        select(shelf, begin="2026-11-24", end="2026-11-23")
