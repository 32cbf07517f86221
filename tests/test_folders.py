"""Folders that a bare machine may lack."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from wax import folders
from wax.errors import StateError


def test_a_home_that_is_not_there_stays_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    """The path is found where there is a home, and is no error where there is none."""
    monkeypatch.setenv("HOME", "/home/robot")
    assert folders.expanded("~/film.mp4") == Path("/home/robot/film.mp4")
    assert folders.expanded("~nobody-of-this-name/film.mp4") == Path(
        "~nobody-of-this-name/film.mp4"
    )


def test_temporary_files_end_with_their_folder() -> None:
    """It is there while it is used."""
    with folders.temporary("wax-") as folder:
        assert Path(folder).is_dir()
    assert not Path(folder).exists()


def test_no_room_for_temporary_files_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It names the variable that helps."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(StateError, match="TMPDIR"):
        folders.temporary("wax-")
