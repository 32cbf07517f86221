"""What the host reads about a source whose pictures are of unknown age."""

from __future__ import annotations

import pytest

from wax.capture.undated import undated


@pytest.mark.parametrize(
    ("source", "says"),
    [
        ("http://me:secret@cam/snapshot.jpg?token=t", "http://cam/snapshot.jpg, because"),
        ("rtsp://me:secret@cam/live", "Set a constant frame rate"),
        ("robot", "synchronise its clock"),
        ("tests.commands.doctor.sources:Undated", "within_s with each Picture"),
        ("still.png", "name a camera of 'wax devices'"),
    ],
)
def test_it_is_said_what_to_do(source: str, says: str) -> None:
    """Each kind of source has its remedy, and no sentence contains a password."""
    told = str(undated(source))
    assert says in told
    assert "secret" not in told
    assert "nobody drives" in told.lower()
