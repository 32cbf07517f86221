"""`wax tape export --mcap`, read by the libraries of MCAP and of Protocol Buffers."""

from __future__ import annotations

import errno
from collections import defaultdict
from typing import TYPE_CHECKING, Any, Literal

import av
import cv2
import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap.writer import Writer
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
from tests.tape.packets import pictures, sounds

from wax.dataset.mcap_export import export_mcap
from wax.errors import StateError
from wax.protocol.tape_events import Faulted, Named, Stopped
from wax.tape.segment import Segment
from wax.tape.selection import Selection, select

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from tests.dataset.driven_tape import Timed

    from wax.tape.shelf import Shelf


TIMES_S = [number / FPS for number in range(30)]
DRIVEN: list[Timed] = [
    (0.0, turned(1)),
    (0.1, Named(viewer=1, name="Ada")),
    (0.1, steered(0.5, 0.25)),
    (0.15, commanded(held=True)),
    (0.2, reported(1.5, heading_rad=np.pi, battery_fraction=0.75)),
    (0.3, steered(0.2, 0.25, limit="long_delay")),
    (0.4, steered(0.0, reason="not_held")),
    (0.5, Stopped(number=1, pressed=True, viewer=1, by_host=False)),
    (0.6, Faulted(operator=1, why="too_old")),
    (1.4, turned(1, None)),
]
Codec = Literal["vp8", "h264"]


def decode(path: Path) -> dict[str, list[tuple[float, Any]]]:
    """Return each topic's messages and their times on the tape, by nothing but the file."""
    found = defaultdict(list)
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            assert schema is not None
            files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
            pool = descriptor_pool.DescriptorPool()
            for one in files.file:
                pool.Add(one)
            known = pool.FindMessageTypeByName(schema.name)
            read: Any = message_factory.GetMessageClass(known).FromString(message.data)
            if "timestamp" in known.fields_by_name:
                assert read.timestamp.ToNanoseconds() == message.log_time
            found[channel.topic].append((message.log_time / 1e9 - BEGAN_S, read))
    return found


def exported(
    tape: Shelf,
    events: Sequence[Timed] = DRIVEN,
    codec: Codec = "vp8",
    *,
    jpeg: bool = False,
) -> dict[str, list[tuple[float, Any]]]:
    """Write a tape, export it, and read that."""
    write_part(tape, events, TIMES_S, codec=codec, is_keyframe=lambda number: number % 20 == 0)
    path = tape.folder.with_name("tape.mcap")
    export_mcap(select(tape), path, jpeg=jpeg, tell=print)
    assert [one.name for one in path.parent.glob("tape.*")] == ["tape.mcap"]
    return decode(path)


def test_a_picture_in_vp8_becomes_jpeg(tape: Shelf) -> None:
    """Each is dated by its capture, in a schema that viewers show."""
    shown = exported(tape)["/camera/driving_view"]
    assert len(shown) == len(TIMES_S)
    for at_s, image in shown:
        assert (image.DESCRIPTOR.full_name, image.format) == ("foxglove.CompressedImage", "jpeg")
        bgr = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_COLOR)
        assert bgr is not None
        assert bgr.shape[:2] == SIZE[::-1]
        assert shown_s(bgr[:, :, 1], BEGAN_S + at_s) - BEGAN_S == pytest.approx(at_s, abs=0.002)


def test_a_picture_in_h264_is_copied(tape: Shelf) -> None:
    """A decoder without any header shows each one at its time."""
    shown = exported(tape, codec="h264")["/camera/driving_view"]
    decoder = av.CodecContext.create("h264", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    decoder.flags |= av.codec.context.Flags.low_delay
    frames = []
    for _, video in shown:
        assert (video.DESCRIPTOR.full_name, video.format) == ("foxglove.CompressedVideo", "h264")
        frames += decoder.decode(av.Packet(video.data))
    frames += decoder.decode(None)
    assert len(frames) == len(TIMES_S)
    for (at_s, _), frame in zip(shown, frames, strict=True):
        picture_s = shown_s(frame.to_ndarray(format="gray"), BEGAN_S + at_s)
        assert picture_s - BEGAN_S == pytest.approx(at_s, abs=0.002)


def test_h264_becomes_jpeg_by_choice(tape: Shelf) -> None:
    """For a viewer without a decoder of H.264."""
    shown = exported(tape, codec="h264", jpeg=True)["/camera/driving_view"]
    assert {image.format for _, image in shown} == {"jpeg"}


def test_what_was_driven_is_there(tape: Shelf) -> None:
    """Velocity, place, battery, and what the gate decided; an unknown number is a gap."""
    found = exported(tape)
    ((at_s, pose),) = found["/pose"]
    assert at_s == pytest.approx(0.2, abs=1e-3)
    assert pose.pose.position.x == 1.5
    assert pose.pose.orientation.z == pytest.approx(1.0)
    assert pose.pose.orientation.w == pytest.approx(0.0)
    speeds = [(one.linear_mps, one.angular_rps) for _, one in found["/wax/steered"]]
    assert speeds == [(0.5, 0.25), (0.2, 0.25), (0.0, 0.0)]
    ((_, robot),) = found["/wax/reported"]
    assert (robot.battery_v, robot.battery_fraction) == (12.0, 0.75)
    ((_, command),) = found["/wax/commanded"]
    assert command.held
    assert np.isnan(command.seen_age_ms)
    assert [(one.name, one.message, one.level) for _, one in found["/log"]] == [
        ("turn", "turn 1 begins", 2),
        ("gate", "passed", 2),
        ("gate", "slowed: long_delay", 3),
        ("gate", "held: not_held", 3),
        ("stop", "Stop 1 is pressed", 3),
        ("fault", "stopped while somebody drove: too_old", 4),
        ("turn", "turn 1 has ended: given up", 2),
    ]


def test_no_name_is_exported(tape: Shelf, tmp_path: Path) -> None:
    """Not even where the host records names."""
    assert "/wax/named" not in exported(tape)
    assert b"Ada" not in (tmp_path / "tape.mcap").read_bytes()


@pytest.mark.parametrize("codec", ["vp8", "h264"])
def test_a_disowned_turn_is_left_out(tape: Shelf, codec: Codec) -> None:
    """Picture, events and place; a picture in H.264 goes on at a keyframe."""
    driven: list[Timed] = [(0.0, turned(1)), (0.2, reported(1.5)), (0.5, turned(1, None))]
    write_part(
        tape,
        [*driven, (0.8, reported(2.5))],
        TIMES_S,
        codec=codec,
        is_keyframe=lambda number: number % 20 == 0,
    )
    tape.disown(BEGAN_S, BEGAN_S + 0.5)
    path = tape.folder.with_name("tape.mcap")
    export_mcap(select(tape), path, tell=print)
    found = decode(path)
    assert [pose.pose.position.x for _, pose in found["/pose"]] == [2.5]
    assert [one.message for _, one in found["/log"]] == []
    times_s = [at_s for at_s, _ in found["/camera/driving_view"]]
    assert all(at_s > 0.5 for at_s in times_s)
    assert len(times_s) == (19 if codec == "vp8" else 10)


def test_sound_is_exported_by_choice(tape: Shelf, tmp_path: Path) -> None:
    """Nobody's voice gets into a file because somebody forgot that it is on the tape."""
    part = Segment(
        tape, origin_s=0.0, zero_ns=round(BEGAN_S * 1e9), codec="vp8", size=SIZE, has_sound=True
    )
    for picture in pictures("vp8", begin_s=0.0, seconds=1.0):
        part.picture(picture)
    for sound in sounds(begin_s=0.0, seconds=1.0):
        part.sound(sound)
    part.close()
    paths = tmp_path / "mute.mcap", tmp_path / "loud.mcap"
    for path in paths:
        export_mcap(select(tape), path, sound=path == paths[1], tell=print)
    assert "/sound" not in decode(paths[0])
    heard = [one for _, one in decode(paths[1])["/sound"]]
    assert {one.DESCRIPTOR.full_name for one in heard} == {"foxglove.RawAudio"}
    samples = sum(len(one.data) // 2 // one.number_of_channels for one in heard)
    assert samples == pytest.approx(48_000, rel=0.03)


def test_only_the_chosen_time_is_exported(tape: Shelf, tmp_path: Path) -> None:
    """Though parts are longer."""
    write_part(tape, [(0.2, reported(1.0)), (0.6, reported(2.0))], TIMES_S)
    path = tmp_path / "tape.mcap"
    chosen = Selection(tape.parts(), BEGAN_S + 0.475, BEGAN_S + 0.975)
    export_mcap(chosen, path, tell=print)
    found = decode(path)
    assert [pose.pose.position.x for _, pose in found["/pose"]] == [2.0]
    assert len(found["/camera/driving_view"]) == 10


def test_a_time_without_anything_is_told(tmp_path: Path) -> None:
    """No empty file is written."""
    with pytest.raises(StateError, match="nothing to export"):
        export_mcap(Selection([]), tmp_path / "tape.mcap", tell=print)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_is_kept(tmp_path: Path) -> None:
    """An export overwrites nothing."""
    path = tmp_path / "tape.mcap"
    path.write_text("mine")
    with pytest.raises(StateError, match="is there already"):
        export_mcap(Selection([]), path, tell=print)
    assert path.read_text() == "mine"


def test_a_full_disk_leaves_nothing_half_written(
    tape: Shelf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The user reads why, and no file is taken for a whole one."""

    def full(*_args: object, **_more: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    write_part(tape, DRIVEN, TIMES_S)
    monkeypatch.setattr(Writer, "add_message", full)
    with pytest.raises(StateError, match="the disk is full; free some, and give the same"):
        export_mcap(select(tape), tmp_path / "tape.mcap", tell=print)
    assert [one.name for one in tmp_path.iterdir()] == ["tape"]


def test_a_part_that_is_half_deleted_is_told(tape: Shelf, tmp_path: Path) -> None:
    """Without its picture the rest is exported, without its events nothing."""
    write_part(tape, DRIVEN, TIMES_S)
    (part,) = tape.parts()
    assert part.media is not None
    assert part.events is not None
    part.media.unlink()
    said = export_mcap(select(tape), tmp_path / "new/tape.mcap", tell=print)
    assert f"left out: {part.name}: has no picture of driving_view" in said
    assert "/pose" in decode(tmp_path / "new/tape.mcap")
    part.events.rename(part.media)
    with pytest.raises(StateError, match=r"nothing to export .*\n.*its events are missing"):
        export_mcap(select(tape), tmp_path / "none.mcap", tell=print)


def test_an_unreadable_part_is_told(tape: Shelf, tmp_path: Path) -> None:
    """The others are exported."""
    write_part(tape, DRIVEN, TIMES_S)
    write_part(tape, [(2.0, reported(9.0))], [one + 2.0 for one in TIMES_S])
    odd: Timed = (4.0, commanded(held=True).model_copy(update={"seq": 2**70}))
    write_part(tape, [odd], [one + 4.0 for one in TIMES_S])
    damaged, _, hostile = tape.parts()
    assert damaged.events is not None
    damaged.events.write_bytes(b"torn")
    path = tmp_path / "tape.mcap"
    said = export_mcap(select(tape), path, tell=print)
    assert damaged.name in said
    assert f"left out: {hostile.name}: Value out of range" in said
    assert [pose.pose.position.x for _, pose in decode(path)["/pose"]] == [9.0]
