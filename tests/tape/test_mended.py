"""A part that a killed server or a power cut has left unfinished is repaired for other readers."""

from __future__ import annotations

import io
import os
import threading
from typing import TYPE_CHECKING, Final

import pytest
from mcap.reader import McapReader, make_reader
from tests.tape.packets import SIZE, in_order, pictures, sounds

from wax.encode.encoded import EncodedPicture
from wax.errors import StateError
from wax.protocol.tape_events import Missed, Named, topic
from wax.state_dir import lock
from wax.tape.command import tape_list, tape_repair
from wax.tape.event_ending import ending_of, finish
from wax.tape.event_file import CUT, METADATA, EventFile
from wax.tape.reading import read_events
from wax.tape.repair import repair
from wax.tape.repaired import finish_media, repaired
from wax.tape.segment import Segment
from wax.tape.shelf import EVENTS, Shelf, unfinished_path

if TYPE_CHECKING:
    from pathlib import Path

ORIGIN_S: Final = 5000.0
ZERO_NS: Final = 1_795_000_000_000_000_000
BEGAN_NS: Final = ZERO_NS + round(ORIGIN_S * 1e9)
CHUNKS: Final = 4
EACH: Final = 3


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[int]]:
    """Return a finished file and the end of each of its chunks."""
    path = tmp_path_factory.mktemp("events") / "part.mcap"
    made = EventFile(path, origin_s=ORIGIN_S, zero_ns=ZERO_NS)
    ends = []
    for number in range(CHUNKS * EACH):
        event = Missed(missed_s=number) if number % EACH else Named(viewer=number, name="Ada")
        made.write(event, ORIGIN_S + number)
        if number % EACH == EACH - 1:
            made.flush()
            ends.append(path.stat().st_size)
    made.close()
    return path.read_bytes(), ends


def mended(data: bytes) -> io.BytesIO:
    file = io.BytesIO(data)
    finish(file, BEGAN_NS)
    return file


def reader_of(file: io.BytesIO) -> McapReader:
    file.seek(0)
    return make_reader(file, validate_crcs=True)


def times_s(file: io.BytesIO, topics: str | None = None) -> list[int]:
    """Return its messages' times, in s, as a seeking reader finds them."""
    found = reader_of(file).iter_messages(topics)
    return [round((message.log_time - BEGAN_NS) / 1e9) for _, _, message in found]


STEPS: Final = [23, pytest.param(1, marks=[pytest.mark.full, pytest.mark.system])]
"""Every so many bytes; the ends of the records are tried in any case."""


def cuts(data: bytes, step: int, ends: list[int]) -> list[int]:
    edges = {end + by for end in ends for by in (-1, 0, 1)}
    return sorted({*range(0, len(data), step), *edges})


@pytest.mark.parametrize("step", STEPS)
def test_a_file_cut_at_any_byte_gets_an_end(step: int, written: tuple[bytes, list[int]]) -> None:
    """All complete chunks are found by seeking readers, also by topic, and are counted."""
    data, ends = written
    for cut in cuts(data, step, [8, *ends]):
        file = mended(data[:cut])
        found = times_s(file)
        whole = sum(end <= cut for end in ends) * EACH
        assert found == list(range(len(found))), cut
        assert whole <= len(found) <= whole + EACH, cut
        assert times_s(file, topic(Named)) == found[::EACH], cut
        reader = reader_of(file)
        assert [one.name for one in reader.iter_metadata()] == [METADATA, CUT], cut
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(found), cut


@pytest.mark.parametrize("step", STEPS)
def test_mending_that_was_cut_off_is_done_again(
    step: int, written: tuple[bytes, list[int]]
) -> None:
    """A repair that was interrupted at any byte is repeated, and marks the cut once."""
    data, ends = written
    once = mended(data[: ends[1] + 20]).getvalue()
    for cut in cuts(once, step, ends[1:2]):
        if cut < ends[1] or cut >= len(once):
            continue
        file = mended(once[:cut])
        assert times_s(file) == list(range(2 * EACH)), cut
        assert [one.name for one in reader_of(file).iter_metadata()] == [METADATA, CUT], cut


def test_what_is_written_is_not_written_again(written: tuple[bytes, list[int]]) -> None:
    """A second failure during a repair destroys no existing record."""
    data, ends = written
    assert mended(data[: ends[2] + 7]).getvalue()[: ends[2]] == data[: ends[2]]


def test_room_that_was_never_written_into_is_cut(written: tuple[bytes, list[int]]) -> None:
    """Zeros, which some file systems leave after a power cut, are cut off."""
    data, ends = written
    assert times_s(mended(data[: ends[1]] + bytes(5000))) == list(range(2 * EACH))


def test_a_damaged_chunk_costs_no_other(written: tuple[bytes, list[int]]) -> None:
    """A damaged chunk stays in place, and no index refers to it."""
    data, ends = written
    broken = bytearray(data[: ends[2]])
    broken[ends[0] + 80] ^= 0xFF
    assert times_s(mended(bytes(broken))) == [0, 1, 2, 6, 7, 8]


@pytest.mark.parametrize("at", [0, 30, 2000])
def test_what_is_damaged_otherwise_stays_as_it_is(
    at: int, written: tuple[bytes, list[int]]
) -> None:
    """A file with an impossible length, after which nothing can be found, stays as it is."""
    data, ends = written
    broken = bytearray(data[: ends[2]])
    broken[at : at + 16] = b"\xff" * 16
    if at == 2000:
        broken[ends[1] : ends[1] + 9] = b"\x06" + b"\xff" * 8
    file = io.BytesIO(broken)
    with pytest.raises(StateError, match="stay as they are"):
        finish(file, BEGAN_NS)
    assert file.getvalue() == broken


# --- whole parts ---------------------------------------------------------------------------------


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    made = Shelf(tmp_path / "tape")
    made.prepare()
    return made


def begun(shelf: Shelf) -> Segment:
    """Begin a part, and write three seconds into it."""
    segment = Segment(
        shelf, origin_s=ORIGIN_S, zero_ns=ZERO_NS, codec="vp8", size=SIZE, has_sound=True
    )
    film = pictures("vp8", begin_s=ORIGIN_S, seconds=3)
    for item in in_order([*film, *sounds(begin_s=ORIGIN_S, seconds=3)]):
        if isinstance(item, EncodedPicture):
            segment.picture(item)
        else:
            segment.sound(item)
    segment.event(Missed(missed_s=1.0), ORIGIN_S + 1)
    segment.flush()
    return segment


def cut_off(shelf: Shelf, to: Shelf) -> None:
    """Write a part, and copy what is on disk before it ends; date it an hour ago."""
    segment = begun(shelf)
    to.prepare()
    for path in shelf.folder.iterdir():
        copy = to.folder / path.name
        copy.write_bytes(path.read_bytes())
        os.utime(copy, (1_795_005_003, 1_795_005_003))
    segment.close()


@pytest.fixture
def torn(shelf: Shelf, tmp_path: Path) -> Shelf:
    made = Shelf(tmp_path / "torn")
    cut_off(shelf, made)
    return made


def test_a_part_that_was_cut_off_is_mended(torn: Shelf, tmp_path: Path) -> None:
    """Media and events can be sought in; the part keeps its end time and stays private."""
    before = torn.parts()[0]
    assert repair(torn).parts == [before.name]
    (part,) = torn.parts()
    assert part.media is not None
    assert part.events is not None
    assert repaired(part.media, tmp_path / "nowhere") == part.media
    with part.events.open("rb") as file:
        assert len(list(make_reader(file).iter_messages())) == 1
    assert part.ended_s == before.ended_s
    assert all(one.stat().st_mode & 0o077 == 0 for one in (part.media,))
    assert {one.name for one in torn.folder.iterdir()} == {part.media.name, part.events.name}
    assert repair(torn).parts == []


def test_the_list_names_what_was_cut_off_and_what_to_do(torn: Shelf) -> None:
    """The list says that a part was cut off and what to do, and later that it was repaired."""
    assert "cut off" in tape_list(torn)
    assert "`wax tape repair`" in tape_list(torn)
    assert tape_repair(torn) == f"Mended: {torn.parts()[0].name}"
    assert "cut off, mended" in tape_list(torn)
    assert "`wax tape repair`" not in tape_list(torn)
    assert tape_repair(torn).startswith("Nothing")


def test_a_replay_says_where_a_mended_part_was_cut_off(torn: Shelf) -> None:
    """A replay still says where a repaired part was cut off."""
    tape_repair(torn)
    events = torn.parts()[0].events
    assert events is not None
    problem = read_events(events).problem
    assert problem is not None
    assert "cut off after 1.0 s" in problem


def test_what_is_being_written_is_left_alone(shelf: Shelf) -> None:
    """A part that is being written is left untouched, and the list says so."""
    segment = begun(shelf)
    before = {path: path.read_bytes() for path in shelf.folder.iterdir()}
    assert repair(shelf).parts == []
    assert {path: path.read_bytes() for path in shelf.folder.iterdir()} == before
    assert "being written" in tape_list(shelf)
    segment.close()
    assert ending_of(shelf.path(segment.name, EVENTS)) == "whole"


def test_who_looks_at_that_moment_only_delays_it(torn: Shelf) -> None:
    """A repair waits for a program that only looks how a part ends."""
    events = torn.parts()[0].events
    assert events is not None
    repairing = threading.Thread(target=repair, args=(torn,))
    with events.open("rb") as looking:
        lock(looking, shared=True)
        repairing.start()
        repairing.join(0.2)
    repairing.join()
    assert ending_of(events) == "mended"


def test_what_is_deleted_meanwhile_does_not_come_back(torn: Shelf) -> None:
    """A part that is deleted during its repair does not reappear."""
    media = torn.parts()[0].media
    assert media is not None
    finish_media(media, is_there=lambda: False)
    assert not media.exists()
    assert not unfinished_path(media).exists()


def test_what_a_mending_has_left_goes_with_its_part(torn: Shelf) -> None:
    """Leftovers of an interrupted repair are deleted with their part."""
    (part,) = torn.parts()
    assert part.media is not None
    unfinished_path(part.media).write_bytes(b"half")
    torn.delete(part.name)
    assert not list(torn.folder.iterdir())


def test_what_cannot_be_mended_is_said_by_its_name(torn: Shelf) -> None:
    """A part that cannot be repaired is reported by name and stays as it is."""
    (part,) = torn.parts()
    assert part.events is not None
    part.events.write_bytes(b"no tape at all" * 10)
    with pytest.raises(StateError, match=rf"{part.name}: its events are damaged"):
        tape_repair(torn)
    assert part.events.read_bytes() == b"no tape at all" * 10
