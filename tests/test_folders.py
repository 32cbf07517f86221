"""Folders that may be missing on a bare machine."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from wax import folders
from wax.errors import StateError


def test_a_home_that_is_not_there_stays_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    """``~`` is expanded if there is a home directory, and kept without an error if not."""
    monkeypatch.setenv("HOME", "/home/robot")
    assert folders.expanded("~/film.mp4") == Path("/home/robot/film.mp4")
    assert folders.expanded("~nobody-of-this-name/film.mp4") == Path(
        "~nobody-of-this-name/film.mp4"
    )


def test_temporary_files_end_with_their_folder() -> None:
    """A temporary folder exists while it is used, and is deleted then."""
    with folders.temporary("wax-") as folder:
        assert Path(folder).is_dir()
    assert not Path(folder).exists()


def test_no_room_for_temporary_files_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A failure to create temporary files is a sentence that names TMPDIR."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(StateError, match="TMPDIR"):
        folders.temporary("wax-")
