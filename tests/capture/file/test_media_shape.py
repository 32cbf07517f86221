"""Media files of every shape become pictures of one size and sound of one rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from wax.capture.source import SAMPLE_RATE_HZ
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path

    from tests.capture.file.conftest import MakeClip, Player


def test_sound_becomes_48_khz_mono(make_clip: MakeClip, open_player: type[Player]) -> None:
    """A stereo tone of 1 kHz at 44.1 kHz is the same tone, as loud, at 48 kHz mono."""
    clip = make_clip("a.wav", video=None, audio="pcm_s16le", rate_hz=44_100, layout="stereo")
    with open_player(clip, video=False) as player:
        player.play(1.0)
    samples = np.concatenate([s.samples for s in player.sounds]).astype(float)
    begin = int(np.flatnonzero(np.abs(samples) > 3000)[0]) + 480
    spectrum = np.abs(np.fft.rfft(samples[begin : begin + 3840] * np.hanning(3840)))
    assert np.argmax(spectrum) * SAMPLE_RATE_HZ / 3840 == pytest.approx(1000, abs=13)
    assert np.abs(samples[begin : begin + 3840]).max() == pytest.approx(0.5 * 32767, rel=0.02)


@pytest.mark.parametrize(("layout", "shape"), [("stereo", (2,)), ("mono", ())])
def test_a_file_has_its_own_channels(
    make_clip: MakeClip, open_player: type[Player], layout: str, shape: tuple[int, ...]
) -> None:
    """With two channels wanted, a stereo file has two and a mono file one, even in its gaps."""
    clip = make_clip("a.wav", video=None, audio="pcm_s16le", rate_hz=44_100, layout=layout)
    with open_player(clip, video=False, channels=2) as player:
        player.play(1.0)
    assert {sound.samples.shape[1:] for sound in player.sounds} == {shape}


def test_a_variable_rate_is_kept(make_clip: MakeClip, open_player: type[Player]) -> None:
    """Pictures of a variable rate appear at their own times; in a long gap the last is repeated."""
    times_ms = [0, 100, 150, 400, 420, 1500, 1600]
    clip = make_clip("a.mkv", audio=None, times_ms=times_ms)
    with open_player(clip, audio=False) as player:
        player.play(1.85)
    times = [picture.captured_s - player.pictures[0].captured_s for picture in player.pictures]
    for time_ms in times_ms:
        assert min(abs(time_s - time_ms / 1000) for time_s in times) < 0.001
    pause = [time_s for time_s in times if 0.43 < time_s < 1.49]
    assert 2 <= len(pause) <= 6
    assert max(np.diff(times)) < 0.51


def test_a_file_without_sound_shows_its_picture(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """Opening the sound of a silent film is an error with a sentence; its picture plays."""
    clip = make_clip("silent.mp4", audio=None)
    player = open_player(clip)
    assert player.video is not None
    assert player.audio is not None
    with pytest.raises(SourceError, match=r"silent\.mp4 contains no sound; set"):
        player.audio.open()
    player.video.open()
    assert player.video.read().width == 160
    player.video.close()


def test_a_file_without_picture_plays_its_sound(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """Opening the picture of a sound file is an error with a sentence; its sound plays."""
    clip = make_clip("radio.ogg", video=None, audio="libopus")
    player = open_player(clip)
    assert player.video is not None
    assert player.audio is not None
    player.audio.open()
    with pytest.raises(SourceError, match=r"radio\.ogg contains no picture; set"):
        player.video.open()
    assert len(player.audio.read().samples) > 0
    player.audio.close()


def test_bare_coded_pictures_play_at_their_rate(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """A bare H.264 stream, which has no time stamps, is timed by counting its packets."""
    clip = make_clip("a.h264", audio=None, seconds=1)
    with open_player(clip, audio=False) as player:
        player.play(2.5)
    steps = np.diff([picture.captured_s for picture in player.pictures])
    assert steps == pytest.approx(0.04, abs=0.011)  # FFmpeg's rate for a stream without one


def test_any_size_is_shown_in_proportion(make_clip: MakeClip, open_player: type[Player]) -> None:
    """A tall, odd-sized film is shown whole between black bars, at the size of the settings."""
    clip = make_clip("a.webm", video="libvpx", audio=None, size=(101, 203))
    with open_player(clip, audio=False) as player:
        player.play(0.5)
    luma = player.pictures[-1].i420[:120]
    assert luma.shape == (120, 160)
    bars = luma.mean(axis=0) < 20
    assert 160 - bars.sum() == pytest.approx(120 * 101 / 203, abs=3)
    assert bars[:40].all()
    assert bars[-40:].all()


@pytest.mark.parametrize(("matrix", "corner"), [("cw", (0, -1)), ("ccw", (-1, 0))])
def test_a_turned_film_is_shown_upright(
    open_player: type[Player], tmp_path: Path, matrix: str, corner: tuple[int, int]
) -> None:
    """A film that a phone marked as rotated is turned as the mark says."""
    clip = tmp_path / "phone.mp4"
    with av.open(str(clip), "w") as out:
        stream = out.add_stream("libx264", rate=30)
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height, stream.pix_fmt = 160, 120, "yuv420p"
        luma = np.full((180, 160), 60, np.uint8)
        luma[120:] = 128
        luma[:60, :80] = 235  # the upper left quarter is bright
        for index in range(30):
            frame = av.VideoFrame.from_ndarray(luma, "yuv420p")
            frame.pts = index
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    upright = np.array([65536, 0, 0, 0, 65536, 0, 0, 0, 1 << 30], ">i4").tobytes()
    one = 65536 if matrix == "cw" else -65536
    turned = np.array([0, one, 0, -one, 0, 0, 0, 0, 1 << 30], ">i4").tobytes()
    data = clip.read_bytes()
    track = data.index(b"tkhd")
    place = data.index(upright, track)
    clip.write_bytes(data[:place] + turned + data[place + len(turned) :])
    with open_player(clip, audio=False) as player:
        player.play(0.5)
    luma = player.pictures[-1].i420[:120]
    shown = luma[:, (luma > 30).any(axis=0)]
    assert shown.shape[1] == pytest.approx(90, abs=3)
    quarters = shown[[10, -10]][:, [10, -10]]
    assert np.unravel_index(np.argmax(quarters), (2, 2)) == tuple(i % 2 for i in corner)
