"""Counts in an MP4 file that exceed its size."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.tape.packets import SIZE, pictures

from wax.errors import StateError
from wax.tape.boxes import is_believable
from wax.tape.repaired import facts_of, repaired
from wax.tape.tape_file import TapeFile

if TYPE_CHECKING:
    from pathlib import Path


def box(kind: bytes, body: bytes) -> bytes:
    return struct.pack("!I4s", 8 + len(body), kind) + body


def run(count: int) -> bytes:
    return box(b"moof", box(b"traf", box(b"trun", struct.pack("!II", 0, count))))


@pytest.fixture
def tape(tmp_path: Path) -> Path:
    """Write a part with a second of H.264."""
    path = tmp_path / "part.mp4"
    made = TapeFile(path, codec="h264", size=SIZE, has_sound=False, origin_s=0.0)
    for picture in pictures("h264", begin_s=0.0, seconds=1.0):
        made.picture(picture)
    made.close()
    return path


def test_a_tape_of_ours_is_believed(tape: Path) -> None:
    assert is_believable(tape)
    assert facts_of(tape).problem is None


def test_more_samples_than_bytes_are_refused_with_a_sentence(tape: Path, tmp_path: Path) -> None:
    """Both ways to open such a file raise a sentence that names it."""
    tape.write_bytes(tape.read_bytes() + run(100_000_000))
    assert "counts more samples" in (facts_of(tape).problem or "")
    with pytest.raises(StateError, match=r"part\.mp4: .*counts more samples"):
        repaired(tape, tmp_path / "copies")


@pytest.mark.parametrize("around", [b"", b"moov", b"traf"])
@pytest.mark.parametrize("kind", [b"trun", b"stts", b"ctts", b"stsc", b"stco"])
def test_a_count_is_found_wherever_its_box_is(tmp_path: Path, around: bytes, kind: bytes) -> None:
    """A count is checked even in a misplaced box, which FFmpeg reads as well."""
    path = tmp_path / "part.mp4"
    inner = box(kind, struct.pack("!II", 0, 1_000_000))
    path.write_bytes(box(b"ftyp", b"iso5") + (box(around, inner) if around else inner))
    assert not is_believable(path)


@given(data=st.binary(max_size=200))
def test_any_bytes_are_looked_over(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    """The check of any bytes ends without an exception."""
    path = tmp_path_factory.getbasetemp() / "any.mp4"
    path.write_bytes(data)
    assert is_believable(path) in (True, False)
