"""The folder of the tape: its parts, its marks, and `wax tape`."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from wax.config.recording import RecordingSettings
from wax.errors import ConfigError, StateError
from wax.tape.command import tape_delete, tape_keep, tape_list
from wax.tape.shelf import Shelf, where

FIRST, SECOND = "wax-20261123T140000Z", "wax-20261123T140100Z"
FIRST_S = 1_795_442_400.0


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    """Two parts of a minute, and another program's files."""
    made = Shelf(tmp_path / "tape")
    made.prepare()
    for number, name in enumerate((FIRST, SECOND)):
        for ending, size in ((".webm", 3000), (".mcap", 1000)):
            path = made.path(name, ending)
            path.write_bytes(bytes(size))
            ended_s = FIRST_S + 60 * (number + 1)
            os.utime(path, (ended_s, ended_s))
    (made.folder / "notes.txt").write_text("mine")
    (made.folder / "wax-20261341T140000Z.mcap").write_text("no such day")
    return made


def test_parts_are_listed_with_their_times_and_sizes(shelf: Shelf) -> None:
    """A part's name gives its start, its newest file its end; other files are ignored."""
    first, second = shelf.parts()
    assert (first.name, first.began_s, first.ended_s) == (FIRST, FIRST_S, FIRST_S + 60)
    assert (first.size_bytes, first.kept, second.name) == (4000, None, SECOND)
    assert first.media == shelf.path(FIRST, ".webm")
    assert "60 s" in tape_list(shelf)
    assert f"\n2 parts, 0.0 MB in {shelf.folder}" in tape_list(shelf)


def test_only_its_owner_can_look_into_the_folder(shelf: Shelf) -> None:
    """Only its owner can read the folder, because it shows people."""
    assert shelf.folder.stat().st_mode & 0o077 == 0


def test_what_cameras_beside_the_driving_view_showed_is_part_of_it(shelf: Shelf) -> None:
    """Other cameras' files count for a part's size and end, and are deleted with it."""
    for camera in (1, 3):
        path = shelf.path(FIRST, f".camera-{camera}.webm")
        path.write_bytes(bytes(500))
        os.utime(path, (FIRST_S + 61, FIRST_S + 61))
    (shelf.folder / f"{FIRST}.camera-9.webm").write_bytes(b"no such camera")
    first = shelf.parts()[0]
    assert (first.name, first.size_bytes, first.ended_s) == (FIRST, 5000, FIRST_S + 61)
    assert first == shelf.part(FIRST)
    assert first.cameras == {
        camera: shelf.path(FIRST, f".camera-{camera}.webm") for camera in (1, 3)
    }
    assert first.media == shelf.path(FIRST, ".webm")
    shelf.delete(FIRST)
    left = {path.name for path in shelf.folder.glob(f"{FIRST}*")}
    assert left == {f"{FIRST}.camera-9.webm"}


def test_a_cameras_file_alone_is_a_part_that_can_be_deleted(shelf: Shelf) -> None:
    """A camera's file alone is a part that can be deleted, so that nothing is left over."""
    name = "wax-20261123T150000Z"
    shelf.path(name, ".camera-2.mp4").write_bytes(bytes(10))
    assert shelf.parts()[-1].name == name
    assert shelf.new_name(shelf.parts()[-1].began_s * 1000) == f"{name}-1"
    tape_delete(shelf, [name])
    assert len(shelf.parts()) == 2


def test_names_do_not_meet(shelf: Shelf) -> None:
    """Two parts that begin within a second have different names in order."""
    name = shelf.new_name(FIRST_S * 1000)
    assert name == f"{FIRST}-1"
    assert sorted([name, FIRST]) == [FIRST, name]
    assert shelf.new_name(FIRST_S * 1000 + 5000) == "wax-20261123T140005Z"


def test_the_hosts_keeping_stays(shelf: Shelf) -> None:
    """A fault does not replace the host's mark; the host's mark replaces a fault's."""
    shelf.keep(FIRST, "fault")
    assert shelf.parts()[0].kept == "fault"
    assert tape_keep(shelf, [FIRST]) == "Kept: 1 part, 0.0 MB."
    shelf.keep(FIRST, "operator")
    assert [one.kept for one in shelf.parts()] == ["host", None]


def test_a_mark_that_says_nothing_keeps(shelf: Shelf) -> None:
    """A part with an unreadable mark is kept."""
    shelf.path(FIRST, ".kept").write_bytes(b"\xff")
    assert shelf.parts()[0].kept == "host"


@pytest.mark.parametrize(
    ("begin_s", "end_s", "are_marked"),
    [
        (10, 20, [True, False]),
        (50, 70, [True, True]),
        (60.5, 70, [True, True]),
        (70, 80, [False, True]),
        (-9, -1, [False] * 2),
    ],
)
def test_a_time_that_is_disowned_is_marked_where_it_is(
    shelf: Shelf, begin_s: float, end_s: float, are_marked: list[bool]
) -> None:
    """Each part that may have something of it says so itself, whichever parts are left later.

    The first may go on for a moment after the second has begun.
    """
    shelf.disown(FIRST_S + begin_s, FIRST_S + end_s)
    assert [one.is_disowned(FIRST_S + begin_s) for one in shelf.parts()] == are_marked
    assert [one.is_disowned(FIRST_S + end_s + 1) for one in shelf.parts()] == [False, False]
    assert [(one.ended_s, one.kept) for one in shelf.parts()] == [
        (FIRST_S + 60, None),
        (FIRST_S + 120, None),
    ]


def test_a_part_may_have_several_disowned_times(shelf: Shelf) -> None:
    """A later mark adds to an earlier one; only the tape's owner may read it."""
    shelf.disown(FIRST_S + 1, FIRST_S + 2)
    shelf.disown(FIRST_S + 5, FIRST_S + 6)
    disowned = ((FIRST_S + 1, FIRST_S + 2), (FIRST_S + 5, FIRST_S + 6))
    assert shelf.parts()[0].disowned == disowned
    assert shelf.path(FIRST, ".disowned").stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("text", [b"\xff", b"1.0\n", b"a b\n"])
def test_a_disowned_mark_that_says_nothing_counts_for_all_times(shelf: Shelf, text: bytes) -> None:
    """Rather too much is left out than anything that is not to be used."""
    shelf.path(FIRST, ".disowned").write_bytes(text)
    assert shelf.parts()[0].is_disowned(FIRST_S + 5)


def test_the_mark_of_a_disowned_time_is_deleted_last(
    shelf: Shelf, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is left of a part that is only half deleted is still not to be used."""
    gone: list[str] = []
    shelf.disown(FIRST_S, FIRST_S + 1)
    monkeypatch.setattr(Path, "unlink", lambda path, **_: gone.append(path.name))
    shelf.delete(FIRST)
    assert gone[-2:] == [f"{FIRST}.disowned", f"{FIRST}.disowned.unready"]


def test_deleting_leaves_nothing(shelf: Shelf) -> None:
    """Deleting removes all files of a part and its marks, and nothing else."""
    shelf.keep(FIRST, "host")
    shelf.disown(FIRST_S, FIRST_S + 1)
    assert tape_delete(shelf, [FIRST]).startswith("Deleted: 1 part")
    assert [one.name for one in shelf.parts()] == [SECOND]
    assert not [one for one in shelf.folder.iterdir() if one.name.startswith(FIRST)]
    assert tape_delete(shelf, [], is_all=True).startswith("Deleted: 1 part")
    assert tape_list(shelf) == f"Nothing is recorded in {shelf.folder}."
    assert (shelf.folder / "notes.txt").exists()


def test_deleting_what_is_older(shelf: Shelf) -> None:
    """Parts that ended before a time in UTC are deleted."""
    tape_delete(shelf, [], before="2026-11-23T14:01:30")
    assert [one.name for one in shelf.parts()] == [SECOND]


@pytest.mark.parametrize("name", ["../records", "wax-1", "", "wax-20261123T140000Z/x"])
def test_no_name_leads_out_of_the_folder(shelf: Shelf, name: str) -> None:
    """A string that is no part's name is refused before any file is touched."""
    with pytest.raises(StateError, match="wax tape list"):
        tape_delete(shelf, [name])
    with pytest.raises(StateError, match="wax tape list"):
        shelf.path(name, ".mcap")
    assert len(shelf.parts()) == 2


@pytest.mark.parametrize(
    ("names", "more"),
    [([], {}), ([FIRST], {"is_all": True}), ([], {"is_all": True, "before": "2026-11-01"})],
)
def test_deleting_needs_one_clear_word(
    shelf: Shelf, names: list[str], more: dict[str, object]
) -> None:
    """Deleting needs exactly one of names, --all and --before."""
    with pytest.raises(ConfigError, match="say what to delete"):
        tape_delete(shelf, names, **more)  # type: ignore[arg-type]  # of the table above
    with pytest.raises(ConfigError, match="--before"):
        tape_delete(shelf, [], before="yesterday")
    assert len(shelf.parts()) == 2


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    """The sentence names the folder and the key."""
    (tmp_path / "file").write_text("")
    with pytest.raises(StateError, match=r"file.*\[recording\] folder"):
        Shelf(tmp_path / "file" / "tape").prepare()


def test_the_folder_is_beside_the_records(tmp_path: Path) -> None:
    """The folder is in the records' folder unless configured otherwise."""
    assert where(RecordingSettings(), str(tmp_path)) == tmp_path / "tape"
    assert where(RecordingSettings(folder="~/t"), "") == Path.home() / "t"
