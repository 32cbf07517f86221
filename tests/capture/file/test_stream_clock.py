"""The age of the pictures of streams and files, with real bytes on a real connection."""

from __future__ import annotations

import statistics
import threading
import time
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

import av
import cv2
import numpy as np
import pytest
from tests.capture.file.http_camera import multipart, serving
from tests.until import until

from wax.capture.file.address import open_container
from wax.capture.file.media_file import MediaFile
from wax.clock import SystemClock
from wax.config.video import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tests.capture.file.conftest import MakeClip
    from tests.capture.file.http_camera import Send

    from wax.capture.source import Picture

    Seen = list[tuple[Picture, float]]

CLOCK = SystemClock()
SIZE = VideoSettings(width=160, height=120)
BITS = 8
CODED = 30


def jpeg(number: int) -> bytes:
    """Return a picture that shows this number in black and white bars."""
    bars = [255 * (number >> bit & 1) for bit in range(BITS)]
    row = np.repeat(np.array(bars, np.uint8), 160 // BITS)
    return cv2.imencode(".jpg", np.tile(row, (120, 1)))[1].tobytes()


def number_of(picture: Picture) -> int:
    """Read what `jpeg` wrote."""
    row = picture.i420[60, : picture.width].reshape(BITS, -1).mean(axis=1)
    return sum(int(grey > 128) << bit for bit, grey in enumerate(row))


def watch(address: str, enough: Callable[[Seen], bool]) -> Seen:
    """Return at least this many pictures, each with the time at which it was read."""
    source = MediaFile(address, CLOCK).video(SIZE)
    source.open()
    seen: Seen = []
    try:
        while not enough(seen):
            seen.append((source.read(), CLOCK.now_s()))
    finally:
        source.close()
    return seen


def some(count: int) -> Callable[[Seen], bool]:
    return lambda seen: len(seen) >= count


def are_dated_by_their_arrival(seen: Seen, taken_s: list[float]) -> bool:
    """Tell whether no picture is dated before it was taken, and half of them soon after."""
    errors_s = [picture.captured_s - taken_s[number_of(picture)] for picture, _ in seen]
    return min(errors_s) >= 0.0 and statistics.median(errors_s) < 0.09


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the first second and the second of repetitions."""
    monkeypatch.setattr("wax.capture.stream_dating._SETTLE_S", 0.2)
    monkeypatch.setattr("wax.capture.stream_dating._REPEATED_S", 0.2)


@pytest.mark.usefixtures("soon")
def test_a_stream_goes_on_during_a_rest() -> None:
    """The newest picture of many is next, its age is known, and the connection stays."""
    taken_s: list[float] = []
    with serving(multipart(map(jpeg, range(150)), 50, taken_s)) as address:
        source = MediaFile(address, CLOCK).video(SIZE)
        source.open()
        first = source.read()
        until(lambda: len(taken_s) > 30)
        source.catch_up()
        newest = source.demuxer.waiting("video")
        picture = source.read()
        source.close()
    assert newest <= 2
    assert number_of(picture) >= 29 > number_of(first)
    assert are_dated_by_their_arrival([(picture, 0.0)], taken_s)


@pytest.mark.usefixtures("soon")
def test_multipart_jpeg_is_as_old_as_it_is() -> None:
    """A camera of 10 pictures a second, which FFmpeg stamps as 25, is dated by arrival."""
    taken_s: list[float] = []
    with serving(multipart(map(jpeg, range(150)), 10, taken_s)) as address:
        seen = watch(address, some(9))
    assert are_dated_by_their_arrival(seen[1:], taken_s)
    assert seen[-1][0].within_s is not None


def test_a_camera_that_forgets_its_first_boundary_is_shown() -> None:
    """A stream that begins with a part's header is shown, each picture once the next has begun."""
    taken_s: list[float] = []
    with serving(multipart(map(jpeg, range(150)), 30, taken_s, first=b"")) as address:
        seen = watch(address, some(12))
    assert are_dated_by_their_arrival(seen[3:], taken_s)


def test_a_page_is_no_camera() -> None:
    """An address that returns a web page is reported as unplayable."""

    def answer(send: Send) -> None:
        send(b"HTTP/1.0 200 OK\r\nContent-Length: 13\r\n\r\n<p>Log in</p>")

    with serving(answer) as address, pytest.raises(SourceError, match="is not a playable"):
        open_container(address)


@pytest.mark.usefixtures("soon")
def test_a_picture_that_is_repeated_is_not_new() -> None:
    """A repeated last picture of a camera that hangs can be watched, but not driven by."""
    hangs = threading.Event()

    def pictures() -> Iterator[bytes]:
        number = 0
        while True:
            yield jpeg(number)
            number += not hangs.is_set()

    def is_old(seen: Seen) -> bool:
        """Let the camera hang once its pictures are dated; wait until the last one ages."""
        if seen and seen[-1][0].within_s is not None:
            hangs.set()
        return hangs.is_set() and [one.within_s for one, _ in seen[-3:]] == [None] * 3

    with serving(multipart(pictures(), 40, [])) as address:
        seen = watch(address, is_old)
    known = [number_of(picture) for picture, _ in seen if picture.within_s is not None]
    repeated = [number_of(picture) for picture, _ in seen[-3:]]
    assert repeated == [repeated[0]] * 3
    assert repeated[0] >= known[-1]
    assert known.count(repeated[0]) <= 1


def coded(count: int) -> list[bytes]:
    """Return pictures in H.264 as a camera's encoder makes them, without a container."""
    encoder = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height, encoder.pix_fmt = 160, 120, "yuv420p"
    encoder.time_base, encoder.thread_count = Fraction(1, 25), 1
    encoder.options = {"tune": "zerolatency", "preset": "ultrafast"}
    packets = []
    for number in range(count):
        frame = av.VideoFrame(160, 120, "yuv420p")
        for plane in frame.planes:
            plane.update(bytes([8 * number]) * plane.buffer_size)
        frame.pts = number
        packets += [bytes(packet) for packet in encoder.encode(frame)]
    return packets


def coded_number(picture: Picture) -> int:
    """Read how bright `coded` made it."""
    return round(float(picture.i420[: picture.height].mean()) / 8)


def successive(seen: Seen) -> list[tuple[tuple[Picture, float], tuple[Picture, float]]]:
    """Return each pair of pictures of which the second was sent right after the first."""
    return [
        (one, other)
        for one, other in pairwise(seen)
        if coded_number(other[0]) == (coded_number(one[0]) + 1) % CODED
    ]


def test_a_bare_stream_is_dated_by_its_arrival() -> None:
    """Bare H.264 is dated by the hand-over of the previous picture, which this one's arrival ends.

    Pictures that arrive while FFmpeg probes the stream are read all at once.
    """
    frames = coded(CODED)
    sent_s: list[float] = []

    def answer(send: Send) -> None:
        send(b"HTTP/1.1 200 OK\r\nContent-Type: video/h264\r\n\r\n")
        for frame in frames * 20:
            sent_s.append(CLOCK.now_s())
            send(frame)
            time.sleep(1 / 60)

    with serving(answer) as address:
        seen = watch(address, lambda seen: len(successive(seen)) > 5)
    for (_, before_s), (picture, _) in successive(seen):
        assert picture.captured_s <= before_s
    number = 0
    for picture, _ in seen:  # after more than half a second without one: of an earlier number
        number += (coded_number(picture) - number) % CODED
        assert picture.captured_s >= sent_s[number]


@pytest.mark.parametrize("length", [True, False])
def test_a_snapshot_is_nobodys(*, length: bool) -> None:
    """The age of a JPEG that is requested repeatedly, with a length or without, is unknown."""
    content = jpeg(9)

    def answer(send: Send) -> None:
        told = f"Content-Length: {len(content)}\r\n" if length else ""
        send(f"HTTP/1.0 200 OK\r\nContent-Type: image/jpeg\r\n{told}\r\n".encode() + content)

    with serving(answer) as address:
        seen = watch(address, some(2))
    assert all(picture.within_s is None for picture, _ in seen)


def test_a_film_by_http_is_nobodys_and_a_file_is_ours(make_clip: MakeClip) -> None:
    """The same film is of unknown age over HTTP, and a demonstration from this machine."""
    clip = make_clip("a.ts", audio=None, seconds=0.5)
    content = clip.read_bytes()

    def answer(send: Send) -> None:
        send(f"HTTP/1.0 200 OK\r\nContent-Length: {len(content)}\r\n\r\n".encode() + content)

    with serving(answer) as address:
        assert watch(address, some(1))[0][0].within_s is None
    assert watch(str(clip), some(1))[0][0].within_s == 0.0


def test_segments_are_nobodys(make_clip: MakeClip, tmp_path: Path) -> None:
    """The age of an HLS playlist, which lags by its segments, is unknown wherever it is stored."""
    make_clip("a.ts", audio=None, seconds=0.5)
    playlist = tmp_path / "live.m3u8"
    playlist.write_text("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:0.5,\na.ts\n#EXT-X-ENDLIST\n")
    assert watch(str(playlist), some(1))[0][0].within_s is None


def test_a_picture_file_is_nobodys(tmp_path: Path) -> None:
    """The age of a picture file is unknown, because another program may overwrite it."""
    path = tmp_path / "snapshot.jpg"
    path.write_bytes(jpeg(3))
    assert watch(str(path), some(1))[0][0].within_s is None
