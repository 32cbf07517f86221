"""Media files: picture and sound in step, at their own speed, from pass to pass."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.examples import at_length
from tests.until import until

from wax.capture.file.stream_decoder import StreamDecoder
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.capture.file.conftest import MakeClip, Player

    from wax.capture.file.demuxer import Coded


@pytest.mark.parametrize(
    ("name", "video", "audio"),
    [
        ("a.mp4", "libx264", "aac"),
        ("a.webm", "libvpx", "libopus"),
        ("a.ts", "libx264", "aac"),
        *at_length(("a.mov", "mpeg4", "pcm_s16le"), ("a.mkv", "libx264", "aac")),
    ],
)
def test_picture_and_sound_stay_in_step(
    *,
    make_clip: MakeClip,
    open_player: type[Player],
    name: str,
    video: str,
    audio: str,
) -> None:
    """Over three passes each flash is within 20 ms of its beep, and no pass shifts them."""
    clip = make_clip(name, video=video, audio=audio)
    with open_player(clip) as player:
        player.play(6.3)
        flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) == len(beeps) == 6
    assert np.abs(np.subtract(beeps, flashes)).max() < 0.020
    # The padding that encoders add at the end of a file (up to 50 ms) is played.
    assert np.diff(flashes[::2]) == pytest.approx(2.0, abs=0.05)
    assert np.ptp(np.subtract(beeps, flashes)) < 0.003


def test_it_plays_at_its_own_speed(make_clip: MakeClip, open_player: type[Player]) -> None:
    """60 pictures and 2 s of sound take 2 s, delivered when due, in every pass."""
    with open_player(make_clip("a.mp4")) as player:
        began_s = player.clock.now_s()
        player.play(6.2)
    assert player.pictures[0].captured_s == pytest.approx(began_s + 0.2, abs=0.001)
    times = np.array([picture.captured_s for picture in player.pictures])
    assert np.diff(times) == pytest.approx(1 / 30, abs=0.0011)
    assert len(times) == pytest.approx(180, abs=2)


def test_after_a_rest_a_picture_is_fresh_and_its_past_is_not_decoded(
    make_clip: MakeClip, open_player: type[Player], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 54 packets that came during a rest, those from the newest keyframe on are decoded."""
    decoded: list[Coded] = []
    decode = StreamDecoder._decode

    def counting(self: StreamDecoder, item: Coded, *, flush: bool = False) -> Any:
        decoded.append(item)
        return decode(self, item, flush=flush)

    monkeypatch.setattr(StreamDecoder, "_decode", counting)
    clip = make_clip("a.mp4", seconds=6, video="mpeg4")  # a keyframe in twelve pictures
    with open_player(clip, audio=False) as player:
        player.play(0.5)
        decoded.clear()
        player.clock.sleep(1.8)
        assert player.video is not None
        demuxer = player.video.demuxer
        until(lambda: demuxer.waiting("video") > 54)
        player.video.catch_up()
        picture = player.video.read()
        assert -0.04 < player.clock.now_s() - picture.captured_s < 0.11
    assert len(decoded) <= 16


def test_sound_has_no_gap_from_pass_to_pass(make_clip: MakeClip, open_player: type[Player]) -> None:
    """Through five passes the pieces of sound, at most 20 ms each, follow without a gap."""
    with open_player(make_clip("a.mp4", rate_hz=44_100), video=False) as player:
        player.play(10.5)
    ends = [s.captured_s + len(s.samples) / SAMPLE_RATE_HZ for s in player.sounds]
    starts = [s.captured_s for s in player.sounds]
    assert np.abs(np.subtract(starts[1:], ends[:-1])).max() < 1e-6
    assert max(len(s.samples) for s in player.sounds) <= 960
    assert np.diff(player.beeps()) == pytest.approx(1.0, abs=0.001)


def test_silence_where_the_sound_is_shorter(make_clip: MakeClip, open_player: type[Player]) -> None:
    """A file with 1 s of sound and 6 s of picture is silent for the rest of each pass."""
    clip = make_clip("a.mp4", seconds=6, audio_s=1.0)
    with open_player(clip) as player:
        player.play(8)
    assert len(player.beeps()) == 2
    assert player.beeps()[1] - player.beeps()[0] == pytest.approx(6, abs=0.02)
    starts = np.array([s.captured_s for s in player.sounds])
    assert np.diff(starts).max() < 0.021


@pytest.mark.parametrize("stall_s", [1.5, 7.0, *at_length(0.5)])
def test_a_slow_reader_gets_what_is_new(
    make_clip: MakeClip, open_player: type[Player], stall_s: float
) -> None:
    """After a stall the next picture and sound are at most 0.12 s old and still in step."""
    with open_player(make_clip("a.mp4")) as player:
        player.play(1.0)
        player.clock.sleep(stall_s)
        assert player.video is not None
        assert player.audio is not None
        picture, sound = player.video.read(), player.audio.read()
        assert player.clock.now_s() - picture.captured_s < 0.12
        assert player.clock.now_s() - sound.captured_s < 0.12
        player.pictures, player.sounds = [picture], [sound]
        player.play(4)
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) >= 3
    for flash_s in flashes[1:-1]:
        assert min(abs(beep_s - flash_s) for beep_s in beeps) < 0.020


class SlowToWake(threading.Condition):
    """A clock whose busy machine delays one reader after its data has arrived."""

    def wait_for(self, predicate: Callable[[], object], timeout: float | None = None) -> Any:
        there = super().wait_for(predicate, timeout)
        self.release()
        time.sleep(0.02)
        self.acquire()
        return there


@pytest.mark.full
def test_sound_is_not_read_ahead_and_lost_while_the_picture_is_slow_to_wake(
    make_clip: MakeClip, open_player: type[Player], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a stall of 7 s no second lacks its beep, however late the pictures' reader wakes."""
    monkeypatch.setattr(threading, "Condition", SlowToWake)
    with open_player(make_clip("a.mp4")) as player:
        player.play(1.0)
        player.clock.sleep(7.0)
        player.sounds = []
        player.play(2.2)
    assert len(player.beeps()) == 2


def test_one_face_closes_and_opens_while_the_other_plays(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """Picture or sound may close and reopen alone, and they are in step again afterwards."""
    with open_player(make_clip("a.mp4")) as player:
        player.play(1.0)
        video = player.video
        assert video is not None
        video.close()
        video.close()
        player.video = None
        player.play(1.5)
        player.video = video
        video.open()
        player.pictures, player.sounds = [], []
        player.play(4.0)
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) >= 3
    for flash_s in flashes:
        assert min(abs(beep_s - flash_s) for beep_s in beeps) < 0.020
