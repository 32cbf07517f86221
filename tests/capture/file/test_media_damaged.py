"""Damaged media files: what can be played is played, otherwise a sentence says what to do."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest
from tests.examples import at_length

from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path

    from tests.capture.file.conftest import MakeClip, Player


@pytest.mark.parametrize(
    ("name", "video", "audio", "options"),
    [
        ("cut.mp4", "libx264", "aac", {"movflags": "faststart"}),
        ("cut.ts", "libx264", "aac", {}),
        *at_length(("cut.webm", "libvpx", "libopus", {})),
    ],
)
def test_a_file_that_was_cut_off_plays_as_far_as_it_goes(
    *,
    make_clip: MakeClip,
    open_player: type[Player],
    name: str,
    video: str,
    audio: str,
    options: dict[str, str],
) -> None:
    """Half a file plays its half again and again, picture and sound in step."""
    clip = make_clip(name, seconds=4, video=video, audio=audio, options=options)
    clip.write_bytes(clip.read_bytes()[: clip.stat().st_size // 2])
    with open_player(clip) as player:
        player.play(6.5)
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) >= 5
    times = [picture.captured_s for picture in player.pictures]
    assert max(np.diff(times)) < 0.6
    for flash_s in flashes[:5]:
        assert min(abs(beep_s - flash_s) for beep_s in beeps) < 0.020


def test_a_file_without_its_index_is_one_sentence(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """An MP4 file whose index was cut off cannot be played: a sentence says so."""
    clip = make_clip("cut.mp4")
    clip.write_bytes(clip.read_bytes()[:2000])
    with pytest.raises(
        SourceError, match=r"^cut\.mp4 is not a playable video or sound.*use another file\.$"
    ):
        open_player(clip).__enter__()


@pytest.mark.parametrize("content", [b"", b"dear diary\n" * 500, bytes(5000)])
def test_a_file_that_is_no_video_is_one_sentence(
    open_player: type[Player], tmp_path: Path, content: bytes
) -> None:
    """Text, zeros and an empty file under a film's name are refused with what to do."""
    clip = tmp_path / "diary.mp4"
    clip.write_bytes(content)
    with pytest.raises(
        SourceError, match=r"^diary\.mp4 is not a playable video or sound.*use another file\.$"
    ):
        open_player(clip).__enter__()


def test_a_missing_file_is_one_sentence(open_player: type[Player], tmp_path: Path) -> None:
    """The error for a file that was removed names it and says what to do."""
    with pytest.raises(SourceError, match=r"^gone\.mp4 does not exist; .*create it\.$"):
        open_player(tmp_path / "gone.mp4").__enter__()


def test_a_damaged_middle_is_played_over(make_clip: MakeClip, open_player: type[Player]) -> None:
    """Noise in the middle of a file costs some pictures, but not those after it."""
    clip = make_clip("a.ts", seconds=4)
    data = bytearray(clip.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 4000] = np.random.default_rng(1).bytes(4000)
    clip.write_bytes(data)
    with open_player(clip) as player:
        player.play(8.5)
    assert len(player.flashes()) >= 6


def test_a_picture_that_cannot_be_decoded_is_one_sentence(
    open_player: type[Player], tmp_path: Path
) -> None:
    """A file whose every picture is garbage is an error, not an endless wait."""
    path = tmp_path / "garbage.mkv"
    with av.open(str(path), "w") as out:
        stream = out.add_stream("libvpx", rate=30)
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height = 160, 120
        for index in range(150):
            packet = av.Packet(b"\xff" * 50)
            packet.stream, packet.pts, packet.dts = stream, index, index
            packet.time_base, packet.is_keyframe = Fraction(1, 30), True
            out.mux(packet)
    with (
        open_player(path, audio=False) as player,
        pytest.raises(SourceError, match="cannot be decoded"),
    ):
        player.play(20)
