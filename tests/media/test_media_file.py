"""Media files and stream addresses: real files through the real demuxer, on a fake clock."""

from __future__ import annotations

import socket
import threading
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from wax.config import VideoSettings
from wax.errors import SourceError
from wax.media.address import shown_name
from wax.media.file import FileAudio, FileVideo, MediaFile

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from wax.media.source import Picture, Sound

RATE_HZ = 48_000
SIZE = VideoSettings(width=160, height=120)
FLASH_S = 0.3
"""In every second of a clip a flash and a beep begin here and last 0.1 s."""


class FakeClock:
    """Moves when somebody sleeps on it."""

    def __init__(self) -> None:
        self.time_s = 500.0

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return 0

    def sleep(self, duration_s: float) -> None:
        self.time_s += duration_s


def make_clip(
    path: Path,
    *,
    seconds: float = 2.0,
    video: str | None = "libx264",
    audio: str | None = "aac",
    size: tuple[int, int] = (160, 120),
    audio_s: float | None = None,
    rate_hz: int = RATE_HZ,
    layout: str = "mono",
    times_ms: list[int] | None = None,
    options: dict[str, str] | None = None,
) -> Path:
    """Write a clip with a flash and a beep in each second; `times_ms` for a variable rate."""
    times = times_ms or [round(index * 1000 / 30) for index in range(round(seconds * 30))]
    with av.open(str(path), "w", options=options or {}) as out:
        streams: list[av.VideoStream | av.AudioStream] = []
        if video is not None:
            picture = out.add_stream(video, rate=30)
            assert isinstance(picture, av.VideoStream)
            picture.width, picture.height, picture.pix_fmt = *size, "yuv420p"
            picture.gop_size = 15
            picture.codec_context.time_base = Fraction(1, 1000)
            streams.append(picture)
        if audio is not None:
            sound = out.add_stream(audio, rate=rate_hz, layout=layout)
            assert isinstance(sound, av.AudioStream)
            streams.append(sound)
        packets = []
        for stream in streams:
            frames = (
                video_frames(times, size)
                if isinstance(stream, av.VideoStream)
                else audio_frames(audio_s or seconds, rate_hz, layout, stream.frame_size or 1024)
            )
            for frame in [*frames, None]:
                packets += stream.encode(frame)
        for packet in sorted(packets, key=lambda p: float((p.dts or 0) * p.time_base)):
            out.mux(packet)
    return path


def video_frames(times_ms: list[int], size: tuple[int, int]) -> Iterator[av.VideoFrame]:
    for time_ms in times_ms:
        frame = av.VideoFrame(*size, "yuv420p")
        flash = (time_ms / 1000 - FLASH_S + 0.001) % 1 < 0.1
        for plane, grey in zip(frame.planes, (235 if flash else 60, 128, 128), strict=True):
            plane.update(bytes([grey]) * plane.buffer_size)
        frame.pts, frame.time_base = time_ms, Fraction(1, 1000)
        yield frame


def audio_frames(seconds: float, rate_hz: int, layout: str, length: int) -> Iterator[av.AudioFrame]:
    time_s = np.arange(round(seconds * rate_hz)) / rate_hz
    beep = np.where((time_s - FLASH_S) % 1 < 0.1, 0.5 * np.sin(2 * np.pi * 1000 * time_s), 0)
    samples = np.round(beep * 32767).astype(np.int16)
    for begin in range(0, len(samples), length):
        piece = samples[begin : begin + length]
        interleaved = np.repeat(piece, 2 if layout == "stereo" else 1).reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(interleaved, "s16", layout)
        frame.sample_rate, frame.pts, frame.time_base = rate_hz, begin, Fraction(1, rate_hz)
        yield frame


class Player:
    """Opens a file's wanted faces on a fake clock and reads whichever is behind."""

    def __init__(self, address: Path | str, *, video: bool = True, audio: bool = True) -> None:
        self.clock = FakeClock()
        file = MediaFile(str(address), self.clock, sleep=self.clock.sleep)
        self.video: FileVideo | None = file.video(SIZE) if video else None
        self.audio: FileAudio | None = file.audio() if audio else None
        self.pictures: list[Picture] = []
        self.sounds: list[Sound] = []

    def __enter__(self) -> Player:
        try:
            for face in (self.video, self.audio):
                if face is not None:
                    face.open()
        except SourceError:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for face in (self.video, self.audio):
            if face is not None:
                face.close()

    def play(self, duration_s: float) -> Player:
        end_s = self.clock.now_s() + duration_s
        while self.clock.now_s() < end_s:
            shown_s = self.pictures[-1].captured_s if self.pictures else 0.0
            heard_s = self.sounds[-1].captured_s if self.sounds else 0.0
            if self.video is not None and (self.audio is None or shown_s <= heard_s):
                self.pictures.append(self.video.read())
            elif self.audio is not None:
                self.sounds.append(self.audio.read())
        return self

    def flashes(self) -> list[float]:
        """Return when each flash began."""
        lit = [picture.i420[: picture.height].mean() > 150 for picture in self.pictures]
        return [
            picture.captured_s
            for picture, now, before in zip(self.pictures[1:], lit[1:], lit, strict=False)
            if now and not before
        ]

    def beeps(self) -> list[float]:
        """Return when each beep began."""
        samples = np.concatenate([sound.samples for sound in self.sounds])
        times = np.concatenate(
            [s.captured_s + np.arange(len(s.samples)) / RATE_HZ for s in self.sounds]
        )
        loud = np.flatnonzero(np.abs(samples.astype(int)) > 3000)
        return [float(times[i]) for i in loud[np.diff(loud, prepend=-RATE_HZ) > RATE_HZ // 5]]


@pytest.mark.parametrize(
    ("name", "video", "audio", "period_s"),
    [
        ("a.mp4", "libx264", "aac", 2.0),
        ("a.mov", "mpeg4", "pcm_s16le", 2.0),
        ("a.webm", "libvpx", "libopus", 2.0),
        ("a.mkv", "libx264", "aac", 2.0),
        ("a.ts", "libx264", "aac", 2.0),
    ],
)
def test_picture_and_sound_stay_in_step(
    tmp_path: Path, name: str, video: str, audio: str, period_s: float
) -> None:
    """Over five passes each flash is within 20 ms of its beep, and no pass shifts them."""
    clip = make_clip(tmp_path / name, video=video, audio=audio)
    with Player(clip) as player:
        player.play(10.3)
        flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) == len(beeps) == 10
    assert np.abs(np.subtract(beeps, flashes)).max() < 0.020
    # What encoders add at the end of a file (up to 50 ms) belongs to the file: it is played.
    assert np.diff(flashes[::2]) == pytest.approx(period_s, abs=0.05)
    assert np.ptp(np.subtract(beeps, flashes)) < 0.003


def test_it_plays_at_its_own_speed(tmp_path: Path) -> None:
    """60 pictures and 2 s of sound take 2 s, delivered when due, in every pass."""
    with Player(make_clip(tmp_path / "a.mp4")) as player:
        began_s = player.clock.now_s()
        player.play(6.2)
    assert player.pictures[0].captured_s == pytest.approx(began_s + 0.2, abs=0.001)
    times = np.array([picture.captured_s for picture in player.pictures])
    assert np.diff(times) == pytest.approx(1 / 30, abs=0.0011)
    assert len(times) == pytest.approx(180, abs=2)


def test_sound_has_no_gap_from_pass_to_pass(tmp_path: Path) -> None:
    """The pieces of sound follow each other to the sample, through five passes, 20 ms at most."""
    with Player(make_clip(tmp_path / "a.mp4", rate_hz=44_100), video=False) as player:
        player.play(10.5)
    ends = [s.captured_s + len(s.samples) / RATE_HZ for s in player.sounds]
    starts = [s.captured_s for s in player.sounds]
    assert np.abs(np.subtract(starts[1:], ends[:-1])).max() < 1e-6
    assert max(len(s.samples) for s in player.sounds) <= 960
    assert np.diff(player.beeps()) == pytest.approx(1.0, abs=0.001)


def test_sound_becomes_48_khz_mono(tmp_path: Path) -> None:
    """A stereo tone of 1 kHz at 44.1 kHz is the same tone, as loud, at 48 kHz mono."""
    clip = make_clip(
        tmp_path / "a.wav", video=None, audio="pcm_s16le", rate_hz=44_100, layout="stereo"
    )
    with Player(clip, video=False) as player:
        player.play(1.0)
    samples = np.concatenate([s.samples for s in player.sounds]).astype(float)
    begin = int(np.flatnonzero(np.abs(samples) > 3000)[0]) + 480
    spectrum = np.abs(np.fft.rfft(samples[begin : begin + 3840] * np.hanning(3840)))
    assert np.argmax(spectrum) * RATE_HZ / 3840 == pytest.approx(1000, abs=13)
    assert np.abs(samples[begin : begin + 3840]).max() == pytest.approx(0.5 * 32767, rel=0.02)


def test_a_variable_rate_is_kept(tmp_path: Path) -> None:
    """Pictures of a variable rate come at their own times; in a long pause the last is repeated."""
    times_ms = [0, 100, 150, 400, 420, 1500, 1600]
    clip = make_clip(tmp_path / "a.mkv", audio=None, times_ms=times_ms)
    with Player(clip, audio=False) as player:
        player.play(1.85)
    times = [picture.captured_s - player.pictures[0].captured_s for picture in player.pictures]
    for time_ms in times_ms:
        assert min(abs(time_s - time_ms / 1000) for time_s in times) < 0.001
    pause = [time_s for time_s in times if 0.43 < time_s < 1.49]
    assert 2 <= len(pause) <= 6
    assert max(np.diff(times)) < 0.51


def test_silence_where_the_sound_is_shorter(tmp_path: Path) -> None:
    """A file with 1 s of sound and 14 s of picture is silent for the rest of each pass."""
    clip = make_clip(tmp_path / "a.mp4", seconds=14, audio_s=1.0)
    with Player(clip) as player:
        player.play(16)
    assert len(player.beeps()) == 2
    assert player.beeps()[1] - player.beeps()[0] == pytest.approx(14, abs=0.02)
    starts = np.array([s.captured_s for s in player.sounds])
    assert np.diff(starts).max() < 0.021


def test_a_file_without_sound_shows_its_picture(tmp_path: Path) -> None:
    """Asked for the sound of a silent film, it says so in a sentence; its picture plays."""
    clip = make_clip(tmp_path / "silent.mp4", audio=None)
    player = Player(clip)
    assert player.video is not None
    assert player.audio is not None
    with pytest.raises(SourceError, match=r"silent\.mp4 has no sound in it; set"):
        player.audio.open()
    player.video.open()
    assert player.video.read().width == 160
    player.video.close()


def test_a_file_without_picture_plays_its_sound(tmp_path: Path) -> None:
    """Asked for the picture of a sound file, it says so in a sentence; its sound plays."""
    clip = make_clip(tmp_path / "radio.ogg", video=None, audio="libopus")
    player = Player(clip)
    assert player.video is not None
    assert player.audio is not None
    player.audio.open()
    with pytest.raises(SourceError, match=r"radio\.ogg has no picture in it; set"):
        player.video.open()
    assert len(player.audio.read().samples) > 0
    player.audio.close()


@pytest.mark.parametrize(
    ("name", "video", "audio", "options"),
    [
        ("cut.mp4", "libx264", "aac", {"movflags": "faststart"}),
        ("cut.webm", "libvpx", "libopus", {}),
        ("cut.ts", "libx264", "aac", {}),
    ],
)
def test_a_file_that_was_cut_off_plays_as_far_as_it_goes(
    tmp_path: Path, name: str, video: str, audio: str, options: dict[str, str]
) -> None:
    """Half a file plays its half again and again, picture and sound in step."""
    clip = make_clip(tmp_path / name, seconds=4, video=video, audio=audio, options=options)
    clip.write_bytes(clip.read_bytes()[: clip.stat().st_size // 2])
    with Player(clip) as player:
        player.play(9)
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) >= 5
    times = [picture.captured_s for picture in player.pictures]
    assert max(np.diff(times)) < 0.6
    for flash_s in flashes[:5]:
        assert min(abs(beep_s - flash_s) for beep_s in beeps) < 0.020


def test_a_file_without_its_index_is_one_sentence(tmp_path: Path) -> None:
    """An MP4 file whose index was cut off cannot be played: a sentence says so."""
    clip = make_clip(tmp_path / "cut.mp4")
    clip.write_bytes(clip.read_bytes()[:2000])
    with pytest.raises(SourceError, match=r"^cut\.mp4 is no video or sound .*name another file\.$"):
        Player(clip).__enter__()


@pytest.mark.parametrize("content", [b"", b"dear diary\n" * 500, bytes(5000)])
def test_a_file_that_is_no_video_is_one_sentence(tmp_path: Path, content: bytes) -> None:
    """Text, zeros and nothing at all under the name of a film are refused with what to do."""
    clip = tmp_path / "diary.mp4"
    clip.write_bytes(content)
    with pytest.raises(
        SourceError, match=r"^diary\.mp4 is no video or sound .*name another file\.$"
    ):
        Player(clip).__enter__()


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    """A file that was taken away is named, with what to do."""
    with pytest.raises(SourceError, match=r"^gone\.mp4 does not exist; .*put it there\.$"):
        Player(tmp_path / "gone.mp4").__enter__()


def test_a_damaged_middle_is_played_over(tmp_path: Path) -> None:
    """Noise in the middle of a file costs some pictures, not the rest of them."""
    clip = make_clip(tmp_path / "a.ts", seconds=4)
    data = bytearray(clip.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 4000] = np.random.default_rng(1).bytes(4000)
    clip.write_bytes(data)
    with Player(clip) as player:
        player.play(8.5)
    assert len(player.flashes()) >= 6


def test_bare_coded_pictures_play_at_their_rate(tmp_path: Path) -> None:
    """A bare H.264 stream, which has no time stamps, is counted out."""
    clip = make_clip(tmp_path / "a.h264", audio=None, seconds=1)
    with Player(clip, audio=False) as player:
        player.play(2.5)
    steps = np.diff([picture.captured_s for picture in player.pictures])
    assert steps == pytest.approx(0.04, abs=0.011)  # FFmpeg's rate where a stream names none


def test_any_size_is_shown_in_proportion(tmp_path: Path) -> None:
    """A tall, odd-sized film is shown whole between black bars, in the size of the settings."""
    clip = make_clip(tmp_path / "a.webm", video="libvpx", audio=None, size=(101, 203))
    with Player(clip, audio=False) as player:
        player.play(0.5)
    luma = player.pictures[-1].i420[:120]
    assert luma.shape == (120, 160)
    bars = luma.mean(axis=0) < 20
    assert 160 - bars.sum() == pytest.approx(120 * 101 / 203, abs=3)
    assert bars[:40].all()
    assert bars[-40:].all()


@pytest.mark.parametrize(("matrix", "corner"), [("cw", (0, -1)), ("ccw", (-1, 0))])
def test_a_turned_film_is_shown_upright(
    tmp_path: Path, matrix: str, corner: tuple[int, int]
) -> None:
    """A film that a phone marked as lying on its side is turned the way that the mark says."""
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
    with Player(clip, audio=False) as player:
        player.play(0.5)
    luma = player.pictures[-1].i420[:120]
    shown = luma[:, (luma > 30).any(axis=0)]
    assert shown.shape[1] == pytest.approx(90, abs=3)
    quarters = shown[[10, -10]][:, [10, -10]]
    assert np.unravel_index(np.argmax(quarters), (2, 2)) == tuple(i % 2 for i in corner)


@pytest.mark.parametrize("stall_s", [0.5, 1.5, 7.0])
def test_a_slow_reader_gets_what_is_new(tmp_path: Path, stall_s: float) -> None:
    """After a stall the next picture and sound are at most 0.12 s old and still in step."""
    with Player(make_clip(tmp_path / "a.mp4")) as player:
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


def test_one_face_closes_and_opens_while_the_other_plays(tmp_path: Path) -> None:
    """Picture and sound come and go on their own, and are in step again afterwards."""
    with Player(make_clip(tmp_path / "a.mp4")) as player:
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


def test_a_picture_that_cannot_be_decoded_is_one_sentence(tmp_path: Path) -> None:
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
        Player(path, audio=False) as player,
        pytest.raises(SourceError, match="cannot be decoded"),
    ):
        player.play(20)


def test_a_live_stream_never_builds_up_delay(tmp_path: Path) -> None:
    """When 3 s of a live stream arrive at once, only the newest is shown; its end is an error."""
    clip = make_clip(tmp_path / "a.ts", seconds=3)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            peer, _ = server.accept()
            with peer:
                peer.sendall(clip.read_bytes())

        thread = threading.Thread(target=serve)
        thread.start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        pictures: list[Picture] = []
        with Player(address, audio=False) as player:
            assert player.video is not None
            thread.join(timeout=5)
            with pytest.raises(SourceError, match="has ended; waiting for it to come back"):
                pictures.extend(iter(player.video.read, None))
    assert all(picture.captured_s <= 500.0 for picture in pictures)
    assert 1 <= len(pictures) < 80
    assert player.clock.now_s() == 500.0


def test_a_file_behind_http_is_played_like_a_file(tmp_path: Path) -> None:
    """A film on a plain web server plays at its own speed, again and again, in step."""
    content = make_clip(tmp_path / "a.ts", seconds=2).read_bytes()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: object) -> None: ...

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            with Player(f"http://127.0.0.1:{server.server_port}/a.ts") as player:
                player.play(6.3)
        finally:
            server.shutdown()
            thread.join()
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) == len(beeps) == 6
    assert np.abs(np.subtract(beeps, flashes)).max() < 0.020


def test_an_address_that_nobody_answers_is_one_sentence() -> None:
    """An unreachable stream is named without its password, with what to do."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(SourceError) as caught:
        Player(f"http://me:secret@127.0.0.1:{port}/live?token=abc").__enter__()
    assert f"http://127.0.0.1:{port}/live cannot be opened" in str(caught.value)
    assert "secret" not in str(caught.value)
    assert "abc" not in str(caught.value)


def test_names_that_people_see_have_no_password() -> None:
    """Of an address host and path are shown, of a file its name."""
    assert shown_name("rtsp://u:p@cam.example:554/a?k=v") == "rtsp://cam.example:554/a"
    assert shown_name("/home/me/clip.mp4") == "clip.mp4"
