"""The recorder's thread delays nobody, and reports what it drops."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final, NamedTuple

import av
import pytest
from tests.tape.packets import SIZE, in_order, pictures, sounds
from tests.turned_clock import TurnedClock
from tests.until import until

from wax.config.recording import RecordingSettings
from wax.encode.encoded import EncodedPicture
from wax.protocol.tape_events import Missed, Named, Stopped, TapeEvent
from wax.sentence import says
from wax.tape import recorder as recorder_module
from wax.tape.reading import read_events
from wax.tape.recorder import DISK_FULL, TAPE_FULL, TOO_SLOW, Format, Recorder
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from pathlib import Path

BEGIN_S: Final = 1000.0
STOPPED: Final = Stopped(number=1, pressed=True, viewer=2, by_host=False)
ADA: Final = Named(viewer=1, name="Ada")


class Disk(NamedTuple):
    """The result of `shutil.disk_usage`."""

    total: int
    used: int
    free: int


class Rig:
    """A recorder with a manual clock and parts of ten seconds."""

    def __init__(self, folder: Path, **settings: object) -> None:
        known = {"segment_s": 10.0, "min_free_gb": 0.0} | settings
        self.clock = TurnedClock(BEGIN_S)
        self.shelf = Shelf(folder)
        self.recorder = Recorder(
            self.shelf,
            settings=RecordingSettings.model_validate(known),
            format=Format("vp8", SIZE, has_sound=True, keyframe_interval_s=1.0),
            clock=self.clock,
        )

    def film(self, begin_s: float, seconds: float) -> None:
        """Merge pictures and sounds in order of capture."""
        film = pictures("vp8", begin_s=begin_s, seconds=seconds)
        for item in in_order([*film, *sounds(begin_s=begin_s, seconds=seconds)]):
            if isinstance(item, EncodedPicture):
                self.recorder.picture(item)
            else:
                self.recorder.sound(item)

    def events(self) -> list[list[TapeEvent]]:
        """Return the events of each part."""
        found = []
        for part in self.shelf.parts():
            assert part.events is not None
            read = read_events(part.events)
            assert read.problem is None
            found.append([one.event for one in read.events])
        return found


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path / "tape")


def _length_s(path: Path | None) -> float:
    with av.open(str(path)) as media:
        assert media.duration is not None
        return media.duration / 1e6


def test_parts_follow_each_other(rig: Rig) -> None:
    """Each part begins with a keyframe once the last is full, and together they hold everything."""
    rig.film(BEGIN_S, 21.0)
    rig.recorder.start()
    rig.recorder.stop(20.0)
    parts = rig.shelf.parts()
    assert len(parts) == 3
    lengths = [_length_s(one.media) for one in parts]
    assert lengths == pytest.approx([10.0, 10.0, 1.0], abs=0.1)
    status = rig.recorder.status()
    assert (status.problem, status.left_out, status.waiting) == (None, 0, 0)


def test_each_part_can_be_read_alone(rig: Rig) -> None:
    """Lasting events, such as a name or a stop in force, are repeated in each part."""
    rig.film(BEGIN_S, 1.0)
    rig.recorder.event(ADA, BEGIN_S + 0.5, lasts_as=("named", 1))
    rig.recorder.event(STOPPED, BEGIN_S + 0.6)
    rig.film(BEGIN_S + 10.0, 1.0)
    rig.recorder.start()
    rig.recorder.stop(20.0)
    assert rig.events() == [[ADA, STOPPED], [ADA]]


def test_what_is_forgotten_is_repeated_no_more(rig: Rig) -> None:
    """A viewer who has left is not named in later parts."""
    rig.film(BEGIN_S, 1.0)
    rig.recorder.event(ADA, BEGIN_S + 0.5, lasts_as=("named", 1))
    rig.recorder.forget(("named", 1))
    rig.film(BEGIN_S + 10.0, 1.0)
    rig.recorder.start()
    rig.recorder.stop(20.0)
    assert rig.events() == [[ADA], []]


def test_it_tells_how_much_there_is(rig: Rig) -> None:
    """The status has the size as of the last scan, which each part repeats."""
    rig.film(BEGIN_S, 21.0)
    waiting = rig.recorder.status().waiting
    assert waiting >= 21 * 60
    rig.recorder.start()
    rig.recorder.stop(20.0)
    first, second, _ = rig.shelf.parts()
    status = rig.recorder.status()
    assert (status.parts, status.parts_bytes) == (2, first.size_bytes + second.size_bytes)


def test_a_tape_that_gives_up_says_so(rig: Rig) -> None:
    """After giving up everything is dropped, whatever the disk does."""
    rig.recorder.start()
    rig.recorder.give_up(says("it has failed"))
    rig.film(BEGIN_S, 1.0)
    rig.recorder.stop(20.0)
    status = rig.recorder.status()
    assert status.problem == says("it has failed")
    assert status.left_out >= 60
    assert rig.shelf.parts() == []


def test_what_happened_lately_is_kept(rig: Rig) -> None:
    """Only parts that reach into the time to keep are kept."""
    rig.clock.time_s = BEGIN_S
    rig.film(BEGIN_S, 21.0)
    rig.recorder.start()
    until(lambda: len(rig.shelf.parts()) == 3 and rig.recorder.waiting == 0)
    # The files are written now, so their end times follow this machine's clock.
    first, second, third = rig.shelf.parts()
    rig.recorder.keep(BEGIN_S + (second.ended_s - rig.clock.wall_ms() / 1000), "fault")
    rig.recorder.stop(20.0)
    kept = {one.name: one.kept for one in rig.shelf.parts()}
    assert kept[second.name] == kept[third.name] == "fault"
    assert first.ended_s >= second.ended_s or kept[first.name] is None


def test_a_disowned_time_is_marked_even_after_trouble(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its operator was told that it will not be used: what the disk refuses is marked later."""
    monkeypatch.setattr(recorder_module, "RETRY_S", 0.0)
    disown, refused = rig.shelf.disown, [OSError("worn out")]

    def disown_later(begin_s: float, end_s: float) -> None:
        if refused:
            raise refused.pop()
        disown(begin_s, end_s)

    monkeypatch.setattr(rig.shelf, "disown", disown_later)
    rig.film(BEGIN_S, 21.0)
    rig.recorder.disown(BEGIN_S + 12.5, BEGIN_S + 15.0)
    rig.recorder.start()
    until(lambda: any(one.disowned for one in rig.shelf.parts()))
    rig.recorder.stop(20.0)
    (_, second, _) = (one.disowned for one in rig.shelf.parts())
    began_s = rig.clock.wall_ms() / 1000
    assert [one.disowned for one in rig.shelf.parts()] == [(), second, ()]
    assert second == ((began_s + 12.5, began_s + 15.0),)


def test_a_slow_disk_leaves_out_whole_parts_and_says_so(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the disk is behind items are dropped, nobody waits, and the gap is recorded."""
    monkeypatch.setattr(recorder_module, "MOST_WAITING", 80)
    rig.film(BEGIN_S, 2.0)  # more than the queue holds: the thread has not started
    assert rig.recorder.problem == TOO_SLOW
    left_out = rig.recorder.status().left_out
    assert left_out > 0
    rig.recorder.start()
    until(lambda: rig.recorder.waiting == 0)
    rig.clock.time_s += 5.0
    rig.film(BEGIN_S + 5.0, 0.5)
    rig.recorder.stop(20.0)
    assert rig.recorder.status().left_out == left_out
    assert rig.recorder.problem is None
    first, second = rig.events()
    assert first == [Missed(missed_s=5.0)]
    assert second == []
    assert _length_s(rig.shelf.parts()[1].media) == pytest.approx(0.5, abs=0.1)


def test_a_full_disk_stops_the_tape_until_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk is reported and costs no existing part; recording resumes when there is room."""
    monkeypatch.setattr(recorder_module, "RETRY_S", 0.0)
    free = {"bytes": 10**9}
    monkeypatch.setattr("shutil.disk_usage", lambda _: Disk(10**12, 0, free["bytes"]))
    rig = Rig(tmp_path / "tape", min_free_gb=2.0)
    rig.recorder.start()
    until(lambda: rig.recorder.problem is not None)
    assert rig.recorder.problem == DISK_FULL
    assert rig.shelf.parts() == []
    free["bytes"] = 3 * 10**9
    until(lambda: rig.recorder.problem is None)
    rig.film(BEGIN_S, 1.0)
    rig.recorder.stop(20.0)
    assert len(rig.shelf.parts()) == 1


def test_a_tape_that_is_full_of_what_is_kept_says_so(tmp_path: Path) -> None:
    """A tape that is full of the host's kept parts reports it instead of deleting them."""
    rig = Rig(tmp_path / "tape", max_gb=0.1)
    rig.shelf.prepare()
    name = rig.shelf.new_name(0)
    with rig.shelf.path(name, ".webm").open("wb") as file:
        file.truncate(200_000_000)
    rig.shelf.keep(name, "host")
    rig.recorder.start()
    until(lambda: rig.recorder.problem is not None)
    rig.recorder.stop(20.0)
    assert rig.recorder.problem == TAPE_FULL
    assert [one.name for one in rig.shelf.parts()] == [name]


def test_the_oldest_goes_for_the_newest(tmp_path: Path) -> None:
    """The tape stays within its size by deleting its oldest parts."""
    rig = Rig(tmp_path / "tape", max_gb=0.1)
    rig.shelf.prepare()
    old = rig.shelf.new_name(50_000)
    with rig.shelf.path(old, ".webm").open("wb") as file:
        file.truncate(200_000_000)
    rig.film(BEGIN_S, 1.0)
    rig.recorder.start()
    rig.recorder.stop(20.0)
    assert rig.recorder.problem is None
    assert old not in [one.name for one in rig.shelf.parts()]
    assert len(rig.shelf.parts()) == 1


def test_a_folder_that_is_none_is_said(tmp_path: Path) -> None:
    """With an unusable folder the server runs, and its page says why nothing is recorded."""
    (tmp_path / "file").write_text("")
    rig = Rig(tmp_path / "file" / "tape")
    rig.recorder.start()
    until(lambda: rig.recorder.problem is not None)
    rig.recorder.stop(20.0)
    assert rig.recorder.problem is not None
    assert "[recording] folder" in str(rig.recorder.problem)


def test_what_is_deleted_while_it_is_written_harms_nothing(rig: Rig) -> None:
    """Deleting a part while it is written does no harm."""
    rig.film(BEGIN_S, 2.0)
    rig.recorder.start()
    until(lambda: bool(rig.shelf.parts()) and rig.recorder.waiting == 0)
    for part in rig.shelf.parts():
        rig.shelf.delete(part.name)
    rig.film(BEGIN_S + 2.0, 10.0)
    rig.recorder.stop(20.0)
    assert rig.recorder.problem is None
    assert len(rig.shelf.parts()) == 1


def test_a_power_cut_costs_a_second(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Events a second old are on disk, as is most of the media."""
    kept = tmp_path / "kept"
    kept.mkdir()

    def keep(descriptor: int) -> None:
        for path in rig.shelf.folder.iterdir():
            if os.path.samestat(path.stat(), os.fstat(descriptor)):
                (tmp_path / "new").write_bytes(path.read_bytes())
                (tmp_path / "new").replace(kept / path.name)

    def told() -> int:
        return sum(len(read_events(path).events) for path in kept.glob("*.mcap"))

    def filmed_s() -> float:
        (film,) = kept.glob("*.webm")
        with av.open(str(film)) as media:
            return max(frame.time or 0.0 for frame in media.decode(video=0))

    monkeypatch.setattr(os, "fsync", keep)
    rig.recorder.start()
    for second in range(4):
        rig.film(BEGIN_S + second, 1.0)
        rig.recorder.event(STOPPED, BEGIN_S + second + 0.5)
        until(lambda: rig.recorder.waiting == 0)
        rig.clock.time_s = BEGIN_S + second + 1.5
        until(lambda: told() == second + 1)  # noqa: B023  # it is asked at once
    until(lambda: filmed_s() >= 3.0)
    rig.recorder.stop(20.0)
