"""The two files of a part: readable by others, in step, and playable when cut off."""

from __future__ import annotations

import errno
import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Literal

import av
import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.writer import Writer
from tests.tape.decoded import flashes_s, frames, times_s
from tests.tape.packets import FPS, SIZE, in_order, pictures, sounds

from wax.capture.source import Sound
from wax.congestion.allocation import SoundEncoding
from wax.encode.encoded import EncodedPicture
from wax.encode.sound_encoder import SoundEncoder
from wax.errors import StateError
from wax.protocol.tape_events import EVENTS, FORMAT, Missed, Named, Stopped, Turned, topic
from wax.tape import event_file, reading
from wax.tape import repaired as repaired_module
from wax.tape.event_file import METADATA, ORIGIN, VERSION, EventFile
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of, repaired
from wax.tape.tape_file import ENDINGS, TapeFile

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from wax.encode.encoded import EncodedSound
    from wax.tape.tape_file import Codec

ORIGIN_S: Final = 5000.0
ZERO_NS: Final = 1_795_000_000_000_000_000
CODECS: Final[tuple[Codec, ...]] = ("vp8", "h264")


def record(path: Path, codec: Codec, *, seconds: float, drift_ppm: float = 0.0) -> TapeFile:
    """Write a file in order of arrival, and leave it open."""
    made = TapeFile(path, codec=codec, size=SIZE, has_sound=True, origin_s=ORIGIN_S)
    film = pictures(codec, begin_s=ORIGIN_S, seconds=seconds)
    write(made, [*film, *sounds(begin_s=ORIGIN_S, seconds=seconds, drift_ppm=drift_ppm)])
    return made


def write(made: TapeFile, items: Iterable[EncodedPicture | EncodedSound]) -> None:
    """Write in order of capture."""
    for item in in_order(items):
        if isinstance(item, EncodedPicture):
            made.picture(item)
        else:
            made.sound(item)


@pytest.mark.parametrize("codec", CODECS)
def test_picture_and_sound_are_in_step(codec: Codec, tmp_path: Path) -> None:
    """A flash and its beep stay within 10 ms from start to end, with any sound card."""
    path = tmp_path / f"part{ENDINGS[codec]}"
    record(path, codec, seconds=10, drift_ppm=100).close()
    seen, heard = flashes_s(path, "video"), flashes_s(path, "audio")
    assert len(seen) == len(heard) == 10
    assert max(abs(a - b) for a, b in zip(seen[1:], heard[1:], strict=True)) <= 0.010
    assert len(times_s(path, "video")) == 10 * FPS


@pytest.mark.parametrize("codec", CODECS)
def test_two_channels_are_played_as_two(codec: Codec, tmp_path: Path) -> None:
    """A tone on the left stays there; packets with one channel play on both sides."""
    path = tmp_path / f"part{ENDINGS[codec]}"
    made = TapeFile(
        path, codec=codec, size=None, has_sound=True, origin_s=ORIGIN_S, sound_channels=2
    )
    tone = np.round(8000 * np.sin(np.arange(480) * (2 * np.pi * 1000 / 48_000))).astype(np.int16)
    encoders = [SoundEncoder(SoundEncoding(20, 56_000, 2)), SoundEncoder(SoundEncoding(20, 32_000))]
    for number in range(400):
        samples = np.column_stack((tone, 0 * tone)) if number < 200 else tone
        encoder = encoders[number // 200]
        sound = encoder.encode(Sound(samples, ORIGIN_S + number / 100), number * 480)
        if sound is not None:
            made.sound(sound)
    made.close()
    with av.open(str(path)) as media:
        assert media.streams.audio[0].layout.name == "stereo"
    heard = np.concatenate(
        [np.atleast_2d(frame.to_ndarray()).reshape(2, -1) for frame in frames(path, "audio")],
        axis=1,
    )
    apart, alike = heard[:, 24_000:72_000].std(axis=1), heard[:, 120_000:168_000].std(axis=1)
    assert apart[0] > 20 * apart[1]
    assert alike[0] == pytest.approx(alike[1], rel=0.01)
    assert alike[0] == pytest.approx(apart[0], rel=0.1)


@pytest.mark.full
@pytest.mark.system
@pytest.mark.timeout(300)
def test_an_hour_stays_in_step(tmp_path: Path) -> None:
    """Six parts of ten minutes stay in step with a sound card that gains 180 ms meanwhile."""
    part_s, parts = 600.0, 6
    all_sounds = sounds(begin_s=ORIGIN_S, seconds=part_s * parts, drift_ppm=50)
    for number in range(parts):
        path, begin_s = tmp_path / f"{number}.webm", ORIGIN_S + number * part_s
        made = TapeFile(path, codec="vp8", size=SIZE, has_sound=True, origin_s=begin_s)
        heard_then = (one for one in all_sounds if 0 <= one.captured_s - begin_s + 1 < part_s + 1)
        write(made, [*pictures("vp8", begin_s=begin_s, seconds=part_s), *heard_then])
        made.close()
        seen, heard = flashes_s(path, "video")[1:], np.array(flashes_s(path, "audio"))
        assert len(seen) == part_s - 1
        assert max(np.abs(heard - at_s).min() for at_s in seen) <= 0.010
        path.unlink()


@pytest.mark.parametrize("codec", CODECS)
def test_what_is_not_finished_can_be_played(codec: Codec, tmp_path: Path) -> None:
    """A killed server loses at most a second; a copy of the rest is seekable."""
    path, cut = tmp_path / f"open{ENDINGS[codec]}", tmp_path / f"cut{ENDINGS[codec]}"
    made = record(path, codec, seconds=5)
    cut.write_bytes(path.read_bytes())  # what the operating system has at this moment
    made.close()
    assert times_s(cut, "video")[-1] >= 4.0
    assert times_s(cut, "audio")[-1] >= 4.0
    (tmp_path / "copies").mkdir()
    copy = repaired(cut, tmp_path / "copies")
    assert copy != cut
    assert facts_of(copy).length_ms >= 4000
    assert times_s(copy, "video") == pytest.approx(times_s(cut, "video"), abs=0.002)
    assert repaired(cut, tmp_path / "copies") == copy


@pytest.mark.parametrize("share", [0.3, 0.5, 0.9])
def test_a_file_that_is_cut_in_the_middle_is_played_up_to_there(
    share: float, tmp_path: Path
) -> None:
    """A file that is cut anywhere plays up to the cut."""
    path, cut = tmp_path / "whole.webm", tmp_path / "cut.webm"
    record(path, "vp8", seconds=4).close()
    cut.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    (tmp_path / "copies").mkdir()
    copy = repaired(cut, tmp_path / "copies")
    assert times_s(copy, "video")[-1] >= 4 * share - 1.0


def test_a_finished_file_is_played_as_it_is(tmp_path: Path) -> None:
    """A file in which a browser can seek is not copied."""
    path = tmp_path / "part.webm"
    record(path, "vp8", seconds=1).close()
    assert repaired(path, tmp_path / "nowhere") == path
    facts = facts_of(path)
    assert (facts.has_picture, facts.has_sound, facts.problem) == (True, True, None)


def test_what_is_no_media_file_is_said(tmp_path: Path) -> None:
    """A file that is no media gives one sentence in both ways to open it."""
    path = tmp_path / "part.webm"
    path.write_bytes(b"no film" * 100)
    problem = facts_of(path).problem
    assert problem is not None
    assert problem.startswith("Picture and sound are damaged:")
    with pytest.raises(StateError, match="are damaged"):
        repaired(path, tmp_path / "copies")


@pytest.mark.parametrize("codec", CODECS)
def test_a_file_without_picture_has_sound(codec: Codec, tmp_path: Path) -> None:
    """Without the camera the sound is still recorded."""
    path = tmp_path / f"part{ENDINGS[codec]}"
    made = TapeFile(path, codec=codec, size=None, has_sound=True, origin_s=ORIGIN_S)
    for sound in sounds(begin_s=ORIGIN_S, seconds=1):
        made.sound(sound)
    made.picture(pictures(codec, begin_s=ORIGIN_S, seconds=0.1)[0])
    made.close()
    assert not facts_of(path).has_picture
    assert len(times_s(path, "audio")) >= 49


def test_only_its_owner_reads_a_part(tmp_path: Path) -> None:
    """Only its owner can read a part, because it shows people."""
    TapeFile(tmp_path / "part.webm", codec="vp8", size=SIZE, has_sound=False, origin_s=0.0).close()
    EventFile(tmp_path / "part.mcap", origin_s=0.0, zero_ns=0).close()
    assert all(one.stat().st_mode & 0o077 == 0 for one in tmp_path.iterdir())


# --- events --------------------------------------------------------------------------------------


def events(path: Path) -> EventFile:
    """Write a stop, three seconds after the beginning, and a turn from before it."""
    made = EventFile(path, origin_s=ORIGIN_S, zero_ns=ZERO_NS)
    made.write(Turned(number=3, operator=7, why=None), ORIGIN_S - 10)
    made.write(Stopped(number=1, pressed=True, viewer=2, by_host=False), ORIGIN_S + 3.0)
    return made


def test_events_come_back_as_they_were(tmp_path: Path) -> None:
    """Each event has its time since the beginning; an earlier one is at the beginning."""
    path = tmp_path / "part.mcap"
    events(path).close()
    read = read_events(path)
    assert read.problem is None
    assert read.began_wall_ms == pytest.approx((ZERO_NS + ORIGIN_S * 1e9) / 1e6)
    assert [(one.at_ms, one.event.type) for one in read.events] == [
        (0.0, "turned"),
        (pytest.approx(3000.0), "stopped"),
    ]


def test_others_can_read_them(tmp_path: Path) -> None:
    """The library's own reader finds the messages as JSON, each topic with its JSON schema."""
    path = tmp_path / "part.mcap"
    events(path).close()
    with path.open("rb") as file:
        found = list(make_reader(file).iter_messages())
    for schema, channel, message in found:
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        described = json.loads(schema.data)["properties"]
        assert set(json.loads(message.data)) == set(described)
    assert [channel.topic for _, channel, _ in found] == ["/wax/turned", "/wax/stopped"]


def test_each_kind_of_event_has_a_topic_of_its_own() -> None:
    """No two kinds of events share a topic, since a topic has one schema."""
    assert len({topic(one) for one in EVENTS}) == len(EVENTS)


def test_events_that_are_cut_off_are_read_up_to_there(tmp_path: Path) -> None:
    """Flushed events are read, and a sentence says where they end."""
    path, cut = tmp_path / "open.mcap", tmp_path / "cut.mcap"
    made = events(path)
    made.flush()
    made.write(Missed(missed_s=1.0), ORIGIN_S + 4.0)
    cut.write_bytes(path.read_bytes())
    made.close()
    read = read_events(cut)
    assert [one.event.type for one in read.events] == ["turned", "stopped"]
    assert read.problem is not None
    assert "cut off after 3.0 s" in read.problem


@pytest.mark.parametrize("damage", range(60, 1200, 60))
def test_damage_takes_no_more_than_what_follows(damage: int, tmp_path: Path) -> None:
    """An inverted byte ends the events with a sentence, not an exception."""
    path = tmp_path / "part.mcap"
    events(path).close()
    data = bytearray(path.read_bytes())
    at = damage % len(data)
    data[at] ^= 0xFF
    path.write_bytes(data)
    with suppress(StateError):
        assert len(read_events(path).events) <= 2


def test_a_newer_tape_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tape of a newer version is refused with what to do."""
    path = tmp_path / "part.mcap"
    monkeypatch.setattr(event_file, "FORMAT", FORMAT + 1)
    events(path).close()
    with pytest.raises(StateError, match=r"newer WAX.*update WAX"):
        read_events(path)


def test_an_mcap_of_others_is_refused(tmp_path: Path) -> None:
    """Other programs' recordings and other files are no tape."""
    path = tmp_path / "part.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(StateError, match="is no tape of WAX"):
        read_events(path)
    path.write_bytes(b"")
    with pytest.raises(StateError, match="is no tape of WAX"):
        read_events(path)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    """Fifty gigabytes of events are refused at once with a sentence."""
    path = tmp_path / "part.mcap"
    with path.open("wb") as file:
        file.truncate(50_000_000_000)
    with pytest.raises(StateError, match=r"50\.0 GB"):
        read_events(path)


@pytest.mark.filterwarnings("ignore:Pydantic serializer")
def test_an_event_of_another_version_is_left_out(tmp_path: Path) -> None:
    """Unknown events are skipped, and a sentence counts them."""
    path = tmp_path / "part.mcap"
    made = events(path)
    made.write(Named.model_construct(viewer="nobody", name="Ada"), ORIGIN_S)
    made.close()
    read = read_events(path)
    assert len(read.events) == 2
    assert read.problem is not None
    assert read.problem.startswith("One event is not")


def test_a_kind_of_event_of_a_later_version_is_passed_over(tmp_path: Path) -> None:
    """A new topic of a later version leaves a tape readable."""

    class Sung(Missed):
        type: Literal["sung"] = "sung"  # type: ignore[assignment]  # as another model would say

    path = tmp_path / "part.mcap"
    made = events(path)
    made.write(Sung(missed_s=1.0), ORIGIN_S + 1)
    made.close()
    read = read_events(path)
    assert read.problem is None
    assert [one.event.type for one in read.events] == ["turned", "stopped"]


# --- files of others -----------------------------------------------------------------------------


def with_chunk(path: Path, data: bytes, size: int, compression: str) -> None:
    """Write a tape that is cut off after this chunk."""
    made = events(path)
    made.flush()
    builder = RecordBuilder()
    Chunk(
        compression=compression,
        data=data,
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=0,
        uncompressed_size=size,
    ).write(builder)
    piece = builder.end()  # type: ignore[no-untyped-call]  # the library leaves it out
    whole = path.read_bytes() + piece
    made.close()
    path.write_bytes(whole)


def test_a_piece_that_would_become_too_large_is_not_unpacked(tmp_path: Path) -> None:
    """A few bytes that claim to unpack to a terabyte are refused before the first."""
    path = tmp_path / "part.mcap"
    size = 2**40
    # RFC 8878, 3.1.1: magic number, a descriptor with 8 bytes of size, that size, an empty block.
    frame = b"\x28\xb5\x2f\xfd" + b"\xe0" + size.to_bytes(8, "little") + b"\x01\x00\x00"
    with_chunk(path, frame, size, "zstd")
    with pytest.raises(StateError, match=r"1099\.5 GB of events"):
        read_events(path)


@pytest.mark.parametrize(
    ("data", "size", "compression"),
    [
        (lz4.frame.compress(bytes(1000)), 1000, "lz4"),
        (zstandard.compress(bytes(1000)), 10, "zstd"),
        (b"no frame", 8, "zstd"),
    ],
)
def test_what_we_do_not_pack_is_not_unpacked(
    data: bytes, size: int, compression: str, tmp_path: Path
) -> None:
    """A tape ends before a chunk with unfamiliar compression."""
    path = tmp_path / "part.mcap"
    with_chunk(path, data, size, compression)
    read = read_events(path)
    assert len(read.events) == 2
    assert read.problem is not None
    assert "cut off after 3.0 s" in read.problem


def test_too_many_events_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Too many events are refused, because small ones grow when they are parsed."""
    monkeypatch.setattr(reading, "_MOST_EVENTS", 1)
    path = tmp_path / "part.mcap"
    events(path).close()
    with pytest.raises(StateError, match="has more than 1 events"):
        read_events(path)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_an_event_without_a_number_is_left_out(number: str, tmp_path: Path) -> None:
    """An event with a value that is not a number is skipped, or the page would freeze."""
    path = tmp_path / "part.mcap"
    made = events(path)
    made._writer.add_message(
        made._channel(Missed),
        log_time=ZERO_NS,
        publish_time=ZERO_NS,
        data=f'{{"type": "missed", "missed_s": {number}}}'.encode(),
    )
    made.close()
    read = read_events(path)
    assert [one.event.type for one in read.events] == ["turned", "stopped"]
    assert read.problem is not None
    assert read.problem.startswith("One event")


@pytest.mark.parametrize("origin", ["9" * 400, "-1", "x", ""])
def test_a_beginning_at_no_time_is_said(origin: str, tmp_path: Path) -> None:
    """An impossible start time is an error, because all times count from it."""
    path = tmp_path / "part.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata(METADATA, {VERSION: str(FORMAT), ORIGIN: origin})
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it out
    with pytest.raises(StateError, match="its beginning is damaged"):
        read_events(path)


def test_picture_and_sound_that_are_too_large_are_not_looked_through(tmp_path: Path) -> None:
    """Fifty gigabytes without an index, minutes to scan, are refused at once in both ways."""
    path = tmp_path / "part.webm"
    record(path, "vp8", seconds=1).close()
    os.truncate(path, 50_000_000_000)
    for look in (facts_of, lambda one: repaired(one, tmp_path / "copies")):
        with pytest.raises(StateError, match=r"50 GB of picture and sound.*the tape's folder"):
            look(path)


def test_no_room_for_a_copy_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """When there is no room for a copy the sentence names the folder and what to do."""
    path = tmp_path / "part.webm"
    record(path, "vp8", seconds=2).close()
    os.truncate(path, path.stat().st_size * 3 // 4)
    copies = tmp_path / "copies"
    copies.mkdir()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(repaired_module, "_copy", full)
    with pytest.raises(StateError, match=r"no room in .*TMPDIR"):
        repaired(path, copies)
