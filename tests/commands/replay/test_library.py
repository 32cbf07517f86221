"""What can be replayed: one part or a folder of parts, damaged ones included."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest
from tests.commands.replay.recorded import BEGIN_S, CAMERAS, record

from wax.commands.replay.library import Library
from wax.errors import StateError
from wax.protocol.tape_events import FORMAT
from wax.tape import event_file
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    """Record a tape of two parts."""
    made = Shelf(tmp_path)
    for number in range(2):
        record(made, BEGIN_S + 10 * number)
    return made


def test_all_of_a_folder_is_there(shelf: Shelf) -> None:
    """A folder's parts are listed in order, each with its length and events."""
    library = Library(shelf.folder)
    first, second = library.listing().parts
    assert first.began_wall_ms < second.began_wall_ms
    content = library.content(second.name)
    assert (content.has_picture, content.has_sound, content.problem) == (True, True, None)
    assert content.length_ms == pytest.approx(2000, abs=60)
    assert [one.at_ms for one in content.events] == [pytest.approx(1000)]
    assert content.cameras == []
    assert library.media(first.name) == shelf.path(first.name, ".webm")
    library.close()


@pytest.mark.parametrize("ending", [".webm", ".mcap"])
def test_either_file_of_a_part_stands_for_it(shelf: Shelf, ending: str) -> None:
    """Either file of a part opens it, even renamed."""
    name = shelf.parts()[0].name
    for one in (".webm", ".mcap"):
        shelf.path(name, one).rename(shelf.folder / f"the fall{one}")
    library = Library(shelf.folder / f"the fall{ending}")
    assert [one.name for one in library.listing().parts] == ["the fall"]
    assert len(library.content("the fall").events) == 1
    library.close()


def test_picture_and_sound_alone_can_be_played(shelf: Shelf) -> None:
    """Picture and sound without events play, with a sentence that says so."""
    name = shelf.parts()[0].name
    shelf.path(name, ".mcap").unlink()
    library = Library(shelf.path(name, ".webm"))
    content = library.content(name)
    assert content.has_media
    assert content.problem is not None
    assert "no events" in content.problem
    library.close()


def test_events_alone_can_be_played(shelf: Shelf) -> None:
    """Events without picture and sound can be shown."""
    name = shelf.parts()[0].name
    shelf.path(name, ".webm").unlink()
    library = Library(shelf.path(name, ".mcap"))
    assert not library.content(name).has_media
    with pytest.raises(StateError, match="no picture and sound"):
        library.media(name)
    library.close()


def test_a_part_that_is_cut_is_played_from_a_copy(shelf: Shelf) -> None:
    """A truncated part plays from a copy, which is deleted on close; the tape is unchanged."""
    name = shelf.parts()[0].name
    path = shelf.path(name, ".webm")
    before = path.read_bytes()[: path.stat().st_size * 3 // 4]
    path.write_bytes(before)
    library = Library(path)
    copy = library.media(name)
    assert copy.parent != path.parent
    assert path.read_bytes() == before
    library.close()
    assert not copy.exists()


@pytest.fixture
def filmed(tmp_path: Path) -> tuple[Shelf, str]:
    """Record a part with two cameras other than the driving view, of which one begins later."""
    made = Shelf(tmp_path)
    return made, record(made, BEGIN_S, CAMERAS)


def test_cameras_are_shown_from_when_they_began(filmed: tuple[Shelf, str]) -> None:
    """Each camera has its name, its start and a seekable file."""
    shelf, name = filmed
    library = Library(shelf.folder)
    content = library.content(name)
    assert content.problem is None
    assert [(one.number, one.name) for one in content.cameras] == [(1, "Door"), (2, "Tail")]
    assert [one.began_ms for one in content.cameras] == pytest.approx([0, 500])
    assert library.media(name, 1) == shelf.path(name, ".camera-1.webm")
    assert library.media(name, 2).suffix == ".mp4"
    with pytest.raises(StateError, match="no pictures of camera 3"):
        library.media(name, 3)
    library.close()


@pytest.mark.parametrize("ending", [".webm", ".mcap", ".camera-2.mp4"])
def test_any_file_of_a_renamed_part_finds_its_cameras(
    filmed: tuple[Shelf, str], ending: str
) -> None:
    """A renamed part finds its cameras, even with dots in its new name."""
    shelf, name = filmed
    for one in (".webm", ".mcap", ".camera-1.webm", ".camera-2.mp4"):
        shelf.path(name, one).rename(shelf.folder / f"the.fall{one}")
    library = Library(shelf.folder / f"the.fall{ending}")
    content = library.content("the.fall")
    assert [one.name for one in content.cameras] == ["Door", "Tail"]
    assert content.has_picture
    library.close()


def _damage(path: Path) -> None:
    path.write_bytes(b"no film")


@pytest.mark.parametrize(
    ("spoil", "ending", "said"),
    [
        (_damage, ".camera-1.webm", "The camera Door is left out"),
        (os.unlink, ".camera-1.webm", "What the camera Door showed is not beside this"),
        (_damage, ".webm", "damaged"),
    ],
)
def test_what_is_wrong_with_one_file_leaves_the_others(
    filmed: tuple[Shelf, str], spoil: Callable[[Path], None], ending: str, said: str
) -> None:
    """A damaged file is one sentence, and the others play."""
    shelf, name = filmed
    spoil(shelf.path(name, ending))
    library = Library(shelf.folder)
    content = library.content(name)
    assert content.problem is not None
    assert said in content.problem
    assert [one.name for one in content.cameras][-1] == "Tail"
    assert len(content.cameras) == (2 if ending == ".webm" else 1)
    assert content.has_picture == (ending != ".webm")
    library.close()


def test_a_camera_that_cannot_be_placed_is_left_out(filmed: tuple[Shelf, str]) -> None:
    """A camera whose start is unknown is left out, since it would be out of sync."""
    shelf, name = filmed
    shelf.path(name, ".camera-2.mp4").rename(shelf.path(name, ".camera-4.mp4"))
    library = Library(shelf.folder)
    content = library.content(name)
    assert [one.name for one in content.cameras] == ["Door"]
    assert content.problem is not None
    shelf.path(name, ".mcap").unlink()
    assert library.content(name).cameras == []
    library.close()


def test_a_newer_tape_is_refused_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tape of a newer version is refused at the terminal."""
    monkeypatch.setattr(event_file, "FORMAT", FORMAT + 1)
    name = record(Shelf(tmp_path), BEGIN_S)
    with pytest.raises(StateError, match="newer WAX"):
        Library(tmp_path / f"{name}.mcap")
    library = Library(tmp_path)  # others of the folder may be older
    assert library.listing().parts[0].name == name
    library.close()


@pytest.mark.parametrize("name", ["../x", "wax-20261123T140000Z", ""])
def test_only_what_is_on_the_tape_is_served(shelf: Shelf, name: str) -> None:
    """No name reaches a file outside the tape."""
    library = Library(shelf.folder)
    with pytest.raises(StateError, match="not on this tape"):
        library.content(name)
    with pytest.raises(StateError, match="not on this tape"):
        library.media(name)
    library.close()


def test_what_is_no_tape_is_said(tmp_path: Path) -> None:
    """A folder without a tape, a foreign file and a missing one are each a sentence."""
    with pytest.raises(StateError, match="nothing of a tape"):
        Library(tmp_path)
    (tmp_path / "film.avi").write_text("")
    with pytest.raises(StateError, match="no part of a tape"):
        Library(tmp_path / "film.avi")
    with pytest.raises(StateError, match="does not exist"):
        Library(tmp_path / "gone.mcap")


def test_what_is_large_is_not_looked_through(shelf: Shelf) -> None:
    """Neither listing a folder nor opening one part opens any other.

    The others are pipes: opening one would block for ever.
    """
    asked = shelf.parts()[0].name
    for number in range(300):
        name = shelf.new_name(2e12 + 60_000 * number)
        os.mkfifo(shelf.path(name, ".mcap" if number % 2 else ".webm"))
    library = Library(shelf.folder)
    assert len(library.listing().parts) == 302
    assert library.content(asked).has_media
    assert library.media(asked) == shelf.path(asked, ".webm")
    library.close()


def test_one_look_at_a_part_does_not_depend_on_how_many_there_are(
    shelf: Shelf, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading one part does not list the folder: a browser that seeks does so often."""
    name = shelf.parts()[0].name
    library = Library(shelf.folder)
    monkeypatch.setattr(Shelf, "parts", None)
    assert library.content(name).has_media
    assert library.media(name).exists()
    library.close()
