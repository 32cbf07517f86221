"""`wax tape export --lerobot`, from a tape of the test card to what a trainer reads."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np
import pyarrow.parquet as pq
import pytest
from tests.dataset.driven_tape import (
    BEGAN_S,
    FPS,
    SIZE,
    commanded,
    reported,
    shown_s,
    steered,
    turned,
    write_part,
)
from tests.tape.decoded import flashes_s

from wax import state_dir
from wax.dataset import lerobot, parts, piece_writer
from wax.dataset.command import export_lerobot
from wax.dataset.pictures import PictureFile, picture_file
from wax.dataset.piece_writer import Options
from wax.dataset.video_file import VideoFile
from wax.errors import ConfigError, StateError
from wax.protocol.tape_events import Filmed, Stopped, Tasked
from wax.tape.selection import Selection, select
from wax.tape.shelf import EVENTS, Shelf

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.dataset.driven_tape import Timed


PART_S: Final = 4.0
OPTIONS: Final = Options(
    task="drive",
    units={"motor_c": "°C"},
    choices={"light": ["white", "warm", "red"]},
    drop_under_s=0.5,
)
STOPPED: Final = Stopped(number=1, pressed=True, viewer=2, by_host=False)
RELEASED: Final = STOPPED.model_copy(update={"pressed": False})
VIDEO: Final = "observation.images.driving_view"


def times_s(part: int, seconds: float = PART_S) -> list[float]:
    """Return when a part's pictures are captured: a little unsteady, as cameras are."""
    return [
        part * PART_S + number / FPS + 0.01 * math.sin(number) ** 2
        for number in range(round(seconds * FPS))
    ]


def driven(part: int) -> list[Timed]:
    """Return what happens in a part: what it repeats, then set-points between all pictures.

    A part begins with the capture of its first picture, which arrives 0.1 s later.
    """
    begin_s = part * PART_S
    begin: Timed = (begin_s, turned(1))
    events: list[Timed] = [begin]
    for number in range(3, round(PART_S * 30) + 3):
        at_s = begin_s + number / 30 + 0.002
        events.append((at_s, steered(math.sin(at_s), math.cos(3 * at_s))))
        events.append((at_s, reported(at_s, battery_v=12.0 - at_s / 10)))
        events.append((at_s, commanded(held=number % 30 < 20)))
    repeated = [(begin_s, event) for _, event in driven(part - 1)[-3:-1]] if part else []
    return [begin, *repeated, *events[1:]]


@pytest.fixture(scope="module")
def shelf(tmp_path_factory: pytest.TempPathFactory) -> Shelf:
    """Make a tape of two parts, in which one turn lasts throughout; tests only read it."""
    made = Shelf(tmp_path_factory.mktemp("tape"))
    made.prepare()
    for part in range(2):
        write_part(made, driven(part), times_s(part))
    return made


def exported(shelf: Shelf, folder: Path, **options: Any) -> str:
    """Export all, and return what was printed."""
    said: list[str] = []
    selection = select(shelf, begin=options.pop("begin", None), end=options.pop("end", None))
    said.append(export_lerobot(selection, folder, replace(OPTIONS, **options), tell=said.append))
    return "\n".join(said)


def rows(folder: Path) -> list[dict[str, Any]]:
    """Return the rows of all episodes."""
    paths = sorted((folder / "data").rglob("*.parquet"))
    return [row for path in paths for row in pq.read_table(path).to_pylist()]


def stamped_s(folder: Path, near_s: Sequence[float]) -> list[float]:
    """Read the time off each picture, which must be close to `near_s` since 1970."""
    found: list[float] = []
    for path in sorted((folder / "videos").rglob("*.mp4")):
        with av.open(str(path)) as media:
            for number, picture in enumerate(media.decode(video=0)):
                assert picture.time == pytest.approx(number / FPS)
                gray = picture.to_ndarray(format="gray").astype(np.uint8)
                found.append(shown_s(gray, near_s[len(found)]))
    return found


def test_each_frame_has_its_picture_and_the_set_point_in_force(
    shelf: Shelf, tmp_path: Path
) -> None:
    """The time on each picture is its row's, and the action is what was sent before it, exactly."""
    out = tmp_path / "out"
    assert "1 episodes, 158 frames" in exported(shelf, out)
    found = rows(out)
    captured_s = [row["wax.captured_s"] for row in found]
    assert np.abs(np.subtract(stamped_s(out, captured_s), captured_s)).max() <= 0.5 / FPS
    sent = [
        (BEGAN_S + at_s, (event.linear_mps, event.angular_rps))
        for at_s, event in driven(0) + driven(1)
        if event.type == "steered" and at_s % PART_S
    ]
    for row in found:
        (_, action) = max(one for one in sent if one[0] <= row["wax.captured_s"])
        assert row["action"] == [float(np.float32(value)) for value in action]
    assert {row["wax.held"] for row in found} == {False, True}


def test_it_is_as_lerobot_has_it(shelf: Shelf, tmp_path: Path) -> None:
    """Numbers, names and statistics are where version 3 of the format looks for them."""
    out = tmp_path / "out"
    exported(shelf, out)
    info = json.loads((out / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_frames"]) == ("v3.0", FPS, 158)
    assert not {one for one in info if "wax" in one}  # of a field that it does not know, it warns
    features = info["features"]
    assert features["action"]["names"] == ["linear_mps", "angular_rps"]
    assert features[VIDEO]["shape"] == [SIZE[1], SIZE[0], 3]
    state = ["moving", "x_m", "y_m", "heading_rad", "bumpers", "battery_v"]
    assert features["observation.state"]["names"] == state
    found = rows(out)
    assert found[0].keys() == features.keys() - {VIDEO}
    assert [row["index"] for row in found] == list(range(158))
    (episode,) = pq.read_table(out / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert (episode["dataset_to_index"], episode["tasks"]) == (158, ["drive"])
    stats = json.loads((out / "meta/stats.json").read_text())
    mean = np.mean([row["action"] for row in found], axis=0)
    assert stats["action"]["mean"] == pytest.approx(mean.tolist())
    assert np.shape(stats[VIDEO]["mean"]) == (3, 1, 1)
    assert stats.keys() == features.keys()
    tasks = pq.read_table(out / "meta/tasks.parquet")
    assert tasks.to_pylist() == [{"task_index": 0, "task": "drive"}]
    pandas = json.loads(tasks.schema.metadata[b"pandas"])
    assert pandas["index_columns"] == ["task"]


def test_the_action_may_be_that_of_the_next_frame(shelf: Shelf, tmp_path: Path) -> None:
    """Then each frame has what the frame after it would have, and the last is left out."""
    exported(shelf, tmp_path / "now")
    exported(shelf, tmp_path / "next", acts_next=True)
    now, then = rows(tmp_path / "now"), rows(tmp_path / "next")
    assert [row["action"] for row in then] == [row["action"] for row in now[1:]]
    assert [row["wax.captured_s"] for row in then] == [row["wax.captured_s"] for row in now[:-1]]


def test_an_export_has_nobodys_name(shelf: Shelf, tmp_path: Path) -> None:
    """Neither viewers' numbers nor names are in the files' rows or descriptions."""
    exported(shelf, tmp_path / "out")
    about = "".join(path.read_text() for path in (tmp_path / "out").rglob("*.json"))
    assert "viewer" not in about
    assert "operator" not in about.replace("whether the operator held any control", "")


def test_a_stop_divides_a_turn_and_is_listed(tape: Shelf, tmp_path: Path) -> None:
    """Each piece is an episode of its own; too short ones are left out, with the reason."""
    presses: list[Timed] = [(1.5, STOPPED), (2.0, RELEASED), (3.8, STOPPED)]
    write_part(tape, [*driven(0), *presses], times_s(0))
    said = exported(tape, tmp_path / "out", drop_under_s=1.0)
    assert "2 episodes, 64 frames" in said
    assert "0.5 s: Stop was pressed" in said
    about = json.loads((tmp_path / "out/meta/wax.json").read_text())
    assert [one["why"] for one in about["left_out"]] == ["Stop was pressed", "Stop was pressed"]
    again = exported(tape, tmp_path / "long", drop_under_s=1.7)
    assert "1 episodes" in again
    assert "turn 1: lasts for 1.4 s" in again


def test_a_gap_in_the_pictures_is_never_filled(tape: Shelf, tmp_path: Path) -> None:
    """Half a second without a picture ends an episode; a single missing one does not."""
    shown = [at_s for at_s in times_s(0) if not 1.5 <= at_s < 2.5 and round(at_s * FPS) != 10]
    write_part(tape, driven(0), shown)
    assert "2 episodes" in exported(tape, tmp_path / "out")
    found = rows(tmp_path / "out")
    lengths = [len([row for row in found if row["episode_index"] == n]) for n in range(2)]
    assert lengths == [28, 30]
    captured_s = [row["wax.captured_s"] - BEGAN_S for row in found]
    assert captured_s[7] == captured_s[8]
    assert not [at_s for at_s in captured_s if 1.5 < at_s < 2.5]


@pytest.mark.parametrize("acts_next", [False, True])
def test_an_episode_has_at_least_two_frames(tape: Shelf, tmp_path: Path, acts_next: bool) -> None:
    """A single picture teaches nothing, however short an episode may be; nothing is left of it."""
    shown = [at_s for at_s in times_s(0) if at_s < 2.0 or round(at_s * FPS) == 60]
    write_part(tape, driven(0), shown)
    said = exported(tape, tmp_path / "out", drop_under_s=0.0, acts_next=acts_next)
    assert "1 episodes" in said
    assert f"turn 1: lasts for {0.0 if acts_next else 0.05:.1f} s" in said
    assert len(list((tmp_path / "out").rglob("*.mp4"))) == 1


def test_pictures_after_the_last_event_of_a_part_are_taken(tape: Shelf, tmp_path: Path) -> None:
    """While nothing changes, a part's pictures go on for longer than its events."""
    write_part(tape, [one for one in driven(0) if one[0] < 3.2], times_s(0))
    write_part(tape, driven(1), times_s(1))
    exported(tape, tmp_path / "out", begin="2026-11-23T14:00:03.5")
    first = rows(tmp_path / "out")[0]
    assert first["wax.captured_s"] - BEGAN_S == pytest.approx(3.5, abs=0.011)
    (*_, newest) = (event for at_s, event in driven(0) if at_s < 3.2 and event.type == "steered")
    assert first["action"][0] == pytest.approx(newest.linear_mps)


def test_axes_controls_and_gauges_are_features_by_their_names(tape: Shelf, tmp_path: Path) -> None:
    """An axis is where it was sent last, a control what it was set to or held at; a gauge counts if
    the robot reported it throughout.
    """
    begin: list[Timed] = [
        (0.0, turned(1)),
        (0.001, steered(0.1)),
        (0.001, reported(gauges={"motor_c": 20.0, "gone": 1.0})),
        (0.001, reported(None, connected=False)),
    ]
    later: list[Timed] = [
        (1.0, steered(0.1, axes={"pan": 0.5}, controls={"light": 2.0})),
        (1.0, reported(gauges={"motor_c": 30.0, "odd": 1.0})),
        (2.0, steered(0.2, axes={"pan": 0.5})),
        (3.0, steered(0.2, axes={"pan": 0.5})),
    ]
    write_part(tape, [*begin, *later], times_s(0))
    exported(tape, tmp_path / "out")
    features = json.loads((tmp_path / "out/meta/info.json").read_text())["features"]
    names = ["linear_mps", "angular_rps", "axis.pan", "control.light"]
    assert features["action"]["names"] == names
    state = features["observation.state"]["names"]
    assert state[1] == "x_m"
    assert state[6:] == ["gauge.motor_c"]
    found = rows(tmp_path / "out")
    seen = {(*row["action"][2:], row["observation.state"][-1]) for row in found}
    assert seen == {(0.0, 0.0, 20.0), (0.5, 2.0, 30.0), (0.5, 0.0, 30.0)}
    about = json.loads((tmp_path / "out/meta/wax.json").read_text())
    assert about["gauges"] == {"motor_c": "°C"}
    assert about["choices"] == {"light": ["white", "warm", "red"]}


def test_sideways_is_an_action_where_there_is_any(tape: Shelf, tmp_path: Path) -> None:
    """A robot that only moves ahead and turns has two actions, this one three."""
    moves = [
        (at_s, steered(0.1, lateral_mps=lateral)) for at_s, lateral in ((0.1, 0.0), (2.0, 0.3))
    ]
    write_part(tape, [*driven(0), *moves], times_s(0))
    exported(tape, tmp_path / "out")
    features = json.loads((tmp_path / "out/meta/info.json").read_text())["features"]
    assert features["action"]["names"] == ["linear_mps", "angular_rps", "lateral_mps"]


def test_each_task_has_its_number(tape: Shelf, tmp_path: Path) -> None:
    """What operators said that they do replaces the configured task, each text once."""
    turns: list[Timed] = [(1.0, turned(2)), (2.0, turned(3)), (3.0, turned(4))]
    said: list[Timed] = [
        (at_s, Tasked(turn=turn, text="tidy")) for turn, at_s in ((2, 1.0), (4, 3.0))
    ]
    write_part(tape, [*driven(0), *turns, *said], times_s(0))
    exported(tape, tmp_path / "out")
    tasks = pq.read_table(tmp_path / "out/meta/tasks.parquet").to_pylist()
    assert [one["task"] for one in tasks] == ["drive", "tidy"]
    numbers = dict.fromkeys(
        (row["episode_index"], row["task_index"]) for row in rows(tmp_path / "out")
    )
    assert list(numbers) == [(0, 0), (1, 1), (2, 0), (3, 1)]


def test_each_episode_has_its_files_and_rows(
    tape: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows are numbered through all episodes, files within folders of so many."""
    monkeypatch.setattr(lerobot, "_FILES_A_CHUNK", 2)
    turns: list[Timed] = [(1.0, turned(2)), (2.0, turned(3))]
    write_part(tape, [*driven(0), *turns], times_s(0))
    exported(tape, tmp_path / "out")
    told = pq.read_table(tmp_path / "out/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [row["index"] for row in rows(tmp_path / "out")] == list(
        range(sum(one["length"] for one in told))
    )
    for one in told:
        file = f"chunk-{one['data/chunk_index']:03d}/file-{one['data/file_index']:03d}"
        found = pq.read_table(tmp_path / f"out/data/{file}.parquet").to_pylist()
        assert {row["episode_index"] for row in found} == {one["episode_index"]}
        ends = one["dataset_from_index"], one["dataset_to_index"] - 1
        assert (found[0]["index"], found[-1]["index"]) == ends
        with av.open(str(tmp_path / f"out/videos/{VIDEO}/{file}.mp4")) as media:
            assert sum(1 for _ in media.decode(video=0)) == one["length"]
        assert one[f"videos/{VIDEO}/to_timestamp"] == pytest.approx(one["length"] / FPS)
    assert [one["data/chunk_index"] for one in told] == [0, 0, 1]


def test_events_that_are_cut_off_are_told(tape: Shelf, tmp_path: Path) -> None:
    """What was driven until then is exported; the list says what the part lacks."""
    growing = write_part(tape, driven(0), times_s(0), has_end=False)
    growing.flush()
    (part,) = tape.parts()
    assert part.events is not None
    copy = Shelf(tmp_path / "copy")
    copy.prepare()
    for path in (part.events, part.media):
        assert path is not None
        shutil.copy(path, copy.folder)
    growing.close()
    assert "The events are cut off after" in exported(copy, tmp_path / "out")


def test_another_camera_and_rate_can_be_chosen(tape: Shelf, tmp_path: Path) -> None:
    """Its pictures begin where the events say, and are taken at that rate."""
    write_part(tape, [*driven(0), (1.0, Filmed(camera=1, name="From above"))], times_s(0))
    (part,) = tape.parts()
    assert part.media is not None
    part.media.rename(tape.path(part.name, ".camera-1.webm"))
    exported(tape, tmp_path / "out", camera="From above", fps=5)
    first, second, *_ = rows(tmp_path / "out")
    assert first["wax.captured_s"] == pytest.approx(BEGAN_S + 1.0, abs=0.011)
    assert second["wax.captured_s"] - first["wax.captured_s"] == pytest.approx(0.2, abs=0.02)
    assert (tmp_path / "out/videos/observation.images.From_above").is_dir()
    with pytest.raises(StateError, match="--camera: the tape has no 'Door'; it has From above, dr"):
        exported(tape, tmp_path / "none", camera="Door")


def test_pictures_can_be_copied_as_they_are(tape: Shelf, tmp_path: Path) -> None:
    """H.264 from a keyframe on, one for each frame, stays bit for bit what was recorded."""
    for part in range(2):
        events = driven(part) if part else [*driven(0)[3:], (1.7, turned(1))]
        write_part(tape, events, times_s(part), codec="h264", is_keyframe=lambda n: n % 30 == 0)
    said = exported(tape, tmp_path / "out", copies=True)
    assert "1 episodes, 100 frames" in said
    assert "1.3 s: turn 1: lies before a keyframe" in said
    found = rows(tmp_path / "out")
    captured_s = [row["wax.captured_s"] for row in found]
    assert captured_s[0] - BEGAN_S == pytest.approx(3.0, abs=0.011)
    shown = stamped_s(tmp_path / "out", captured_s)
    assert np.abs(np.subtract(shown, captured_s)).max() <= 0.5 / FPS
    (video,) = (tmp_path / "out/videos").rglob("*.mp4")
    taped = [one for part in tape.parts() for one in _pictures(part.media)]
    assert _pictures(video) == taped[60:]


def _pictures(path: Path | None) -> list[bytes]:
    with av.open(str(path)) as media:
        return [bytes(packet) for packet in media.demux(video=0) if packet.size]


def test_pictures_that_do_not_fit_are_encoded(tape: Shelf, tmp_path: Path) -> None:
    """Where a picture is missing, or at another rate, a copy would be wrong."""
    shown = [at_s for at_s in times_s(0) if round(at_s * FPS) != 40]
    write_part(tape, driven(0), shown, codec="h264", is_keyframe=lambda n: n % 30 == 0)
    exported(tape, tmp_path / "out", copies=True)
    exported(tape, tmp_path / "encoded")
    assert rows(tmp_path / "out") == rows(tmp_path / "encoded")
    videos = [next((tmp_path / name).rglob("*.mp4")) for name in ("out", "encoded")]
    assert _pictures(videos[0]) == _pictures(videos[1])


def test_pictures_with_another_header_are_encoded(
    tape: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of copied pictures has one header, by which the others could not be decoded."""
    for part in range(2):
        write_part(tape, driven(part), times_s(part), codec="h264", is_keyframe=lambda n: n == 0)
    exported(tape, tmp_path / "copied", copies=True)

    def headed(path: Path, origin_s: float) -> PictureFile | None:
        file = picture_file(path, origin_s)
        return None if file is None else replace(file, header=path.name.encode())

    monkeypatch.setattr(parts, "picture_file", headed)
    exported(tape, tmp_path / "out", copies=True)
    taped = [_pictures(part.media) for part in tape.parts()]
    copied, encoded = (
        _pictures(next((tmp_path / name).rglob("*.mp4"))) for name in ("copied", "out")
    )
    assert copied[-len(taped[1]) :] == taped[1]
    assert encoded[-len(taped[1]) :] != taped[1]


def test_pictures_of_another_size_are_left_out(tape: Shelf, tmp_path: Path) -> None:
    """All of a dataset's pictures have one size, the first; what has another is listed."""
    write_part(tape, driven(0), times_s(0))
    write_part(tape, driven(1), times_s(1), size=(320, 240))
    said = exported(tape, tmp_path / "out")
    assert "turn 1: its pictures are 320×240" in said
    assert max(row["wax.captured_s"] for row in rows(tmp_path / "out")) < BEGAN_S + PART_S


def test_sound_is_beside_the_pictures_only_if_asked_for(
    tape: Shelf, shelf: Shelf, tmp_path: Path
) -> None:
    """Each episode's sound is a file that begins with its first picture."""
    for part in range(2):
        events = driven(part) if part else [*driven(0)[1:], (1.5, turned(1))]
        write_part(tape, events, times_s(part), has_sound=True)
    exported(tape, tmp_path / "silent")
    exported(shelf, tmp_path / "mute", sound=True)
    for nothing in ("silent/sound", "mute/sound"):
        assert not any((tmp_path / nothing).rglob("*.ogg"))
    exported(tape, tmp_path / "out", sound=True)
    (heard,) = (tmp_path / "out/sound").rglob("*.ogg")
    begin_s = rows(tmp_path / "out")[0]["wax.captured_s"] - BEGAN_S
    loud_s = [at_s for at_s in flashes_s(heard, "audio") if at_s > 0.2]
    assert loud_s == pytest.approx([second - begin_s for second in range(2, 8)], abs=0.03)


def test_a_time_can_be_chosen(shelf: Shelf, tmp_path: Path) -> None:
    """An episode is clipped to the time asked for."""
    exported(shelf, tmp_path / "out", begin="2026-11-23T14:00:01", end="2026-11-23T14:00:03")
    captured_s = [row["wax.captured_s"] - BEGAN_S for row in rows(tmp_path / "out")]
    assert len(captured_s) == 2 * FPS
    assert captured_s[0] >= 1.0
    assert captured_s[-1] < 3.0


class FullDisk(VideoFile):
    """A disk that is full after the first episode."""

    def __init__(self, path: Path, *, fps: int, size: tuple[int, int]) -> None:
        if path.stem != "file-000":
            raise OSError(errno.ENOSPC, "No space left on device")
        super().__init__(path, fps=fps, size=size)


def test_an_export_that_was_interrupted_goes_on(
    tape: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk leaves nothing that looks whole; the same command then writes the rest."""
    stops: list[Timed] = [(1.9, STOPPED), (2.0, RELEASED)]
    shown = [at_s for at_s in times_s(0) if not 0.3 < at_s < 1.0]
    write_part(tape, [*driven(0), *stops], shown)
    exported(tape, tmp_path / "whole")
    with monkeypatch.context() as patched:
        patched.setattr(piece_writer, "VideoFile", FullDisk)
        with pytest.raises(StateError, match="the disk is full; free some, and give the same"):
            exported(tape, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    partial = tmp_path / "out.partial"
    with pytest.raises(StateError, match="with other options was interrupted here"):
        exported(tape, tmp_path / "out", fps=5)
    with (partial / "unfinished.jsonl").open("ab") as journal:
        journal.write(b'{"piece": [1, ')  # the power failed
    said = exported(tape, tmp_path / "out")
    assert said.startswith("Going on after 1 of 2 turns.\n2 of 2: turn 1")
    assert rows(tmp_path / "out") == rows(tmp_path / "whole")
    about, whole = (tmp_path / name / "meta/wax.json" for name in ("out", "whole"))
    assert about.read_text() == whole.read_text()
    reasons = [one["why"] for one in json.loads(about.read_text())["left_out"]]
    assert reasons == ["Stop was pressed", "turn 1: lasts for 0.2 s", "turn 1: the tape has a gap"]
    assert not partial.exists()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["data", "meta", "videos"]


def test_what_is_finished_outlasts_a_power_cut(
    tape: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An episode's files are on the disk before the journal says that they are there; in the end
    all files are, before the folder has its name.
    """
    done: list[str] = []
    monkeypatch.setattr(state_dir, "sync", lambda path: done.append(path.name))
    monkeypatch.setattr(os, "fsync", lambda _: done.append("journal"))
    turns: list[Timed] = [(2.0, turned(2))]
    write_part(tape, [*driven(0), *turns], times_s(0), has_sound=True)
    done.clear()
    exported(tape, tmp_path / "out", sound=True)
    began, *told = (number for number, name in enumerate(done) if name == "journal")
    assert [sorted(done[after + 1 : at]) for after, at in pairwise((began, *told))] == [
        [f"file-{number:03d}.{kind}" for kind in ("mp4", "ogg", "parquet")] for number in range(2)
    ]
    assert done[-1] == tmp_path.name
    written = {path.name for path in (tmp_path / "out").rglob("*")}
    assert written <= set(done[told[-1] + 1 : -1])


def test_a_part_that_is_deleted_meanwhile_is_told(tape: Shelf, tmp_path: Path) -> None:
    """A server that records deletes its oldest parts, also while they are exported."""
    write_part(tape, driven(0), times_s(0))
    write_part(tape, [*driven(1)[1:], (PART_S, turned(2))], times_s(1))
    media = tape.parts()[1].media
    assert media is not None
    said: list[str] = []

    def tell(text: str) -> None:
        said.append(text)
        media.unlink(missing_ok=True)

    said.append(export_lerobot(select(tape), tmp_path / "out", OPTIONS, tell=tell))
    assert "1 episodes, 80 frames" in said[-1]
    assert f"turn 2: {media.name}: its pictures cannot be read: No such file" in said[-1]


def test_a_turn_that_is_disowned_is_left_out(tape: Shelf, tmp_path: Path) -> None:
    """All its episodes, in each part alone, whatever became of the others; the next turn stays."""
    ends: list[Timed] = [(7.0, turned(1, None)), (7.0, turned(2))]
    stops: list[Timed] = [(5.0, STOPPED), (5.5, RELEASED)]
    write_part(tape, driven(0), times_s(0))
    write_part(tape, [*driven(1), *stops, *ends], times_s(1))
    tape.disown(BEGAN_S, BEGAN_S + 7.0)
    tape.delete(tape.parts()[0].name)
    said = exported(tape, tmp_path / "out")
    assert "1 episodes" in said
    assert said.count("its operator does not want it to be used") == 2
    assert min(row["wax.captured_s"] for row in rows(tmp_path / "out")) >= BEGAN_S + 7.0


def test_a_folder_with_something_in_it_is_left_alone(shelf: Shelf, tmp_path: Path) -> None:
    """Neither the folder nor what lies in the way beside it is touched."""
    (tmp_path / "out").mkdir()
    (tmp_path / "out/mine.txt").write_text("mine")
    with pytest.raises(StateError, match="out: there is something in it already; name a folder"):
        exported(shelf, tmp_path / "out")
    with pytest.raises(StateError, match=r"mine\.txt: there is something in it already"):
        exported(shelf, tmp_path / "out/mine.txt")
    (tmp_path / "empty").mkdir()
    assert "158 frames" in exported(shelf, tmp_path / "empty")
    (tmp_path / "new.partial").mkdir()
    (tmp_path / "new.partial/mine.txt").write_text("mine")
    with pytest.raises(StateError, match=r"new\.partial: is not ours, and in the way"):
        exported(shelf, tmp_path / "new")
    assert (tmp_path / "out/mine.txt").read_text() == "mine"


def test_parts_that_cannot_be_read_are_named(shelf: Shelf, tmp_path: Path) -> None:
    """Torn, half deleted and growing parts cost what they lack, and are listed."""
    tape = Shelf(Path(shutil.copytree(shelf.folder, tmp_path / "tape")))
    growing = write_part(tape, [(20.0, turned(1))], [20.0], has_end=False)
    half = tape.path("wax-20261123T150000Z", ".webm")
    half.write_bytes(b"no events beside it")
    third = write_part(tape, driven(2), times_s(2))
    tape.path(third.name, ".webm").write_bytes(b"torn")
    first = tape.parts()[0]
    assert first.media is not None
    first.media.write_bytes(first.media.read_bytes()[: first.media.stat().st_size // 2])
    empty = tape.path("wax-20261123T160000Z", EVENTS)
    empty.write_bytes(b"\x89MCAP0\r\n")
    said = exported(tape, tmp_path / "out")
    growing.close()
    assert "its events are missing, so nothing says what was driven" in said
    assert f"{growing.name}: is still being written; export it once" in said
    assert f"{third.name}.webm: Picture and sound are damaged" in said
    assert "is no tape of WAX" in said
    assert "the tape has a gap" in said
    captured_s = [row["wax.captured_s"] - BEGAN_S for row in rows(tmp_path / "out")]
    assert min(captured_s) == pytest.approx(0.1, abs=0.02)
    assert not [at_s for at_s in captured_s if 3.0 < at_s < PART_S]


def test_nobody_who_drove_is_a_sentence(tape: Shelf, tmp_path: Path) -> None:
    """A tape on which nobody drove gives no dataset, nor does one that is still written."""
    write_part(tape, [(0.0, steered(0.0))], times_s(0, 1.0))
    with pytest.raises(StateError, match="no turn is recorded that can be exported"):
        exported(tape, tmp_path / "out")
    assert not (tmp_path / "out.partial").exists()


def test_without_pyarrow_a_sentence_says_what_to_install(
    shelf: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The library is an extra."""
    for name in ("wax.dataset.export", "wax.dataset.lerobot"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ConfigError, match=r'needs pyarrow.*pip install "wax-teleop\[dataset\]"'):
        exported(shelf, tmp_path / "out")


@pytest.mark.parametrize(
    "asked", [Options(fps=0), Options(fps=1000), Options(drop_under_s=math.nan)]
)
def test_odd_options_are_refused(tmp_path: Path, asked: Options) -> None:
    """What cannot be meant is wrong usage, said before anything is read."""
    with pytest.raises(ConfigError, match="allowed is"):
        export_lerobot(Selection([]), tmp_path / "out", asked, tell=print)
