"""How old the pictures of streams and files are said to be, by real bytes on a line."""

from __future__ import annotations

import socketserver
import statistics
import threading
import time
from contextlib import contextmanager, suppress
from fractions import Fraction
from typing import TYPE_CHECKING

import av
import cv2
import numpy as np
import pytest

from wax.capture.file.address import open_container
from wax.capture.file.media_file import MediaFile
from wax.clock import SystemClock
from wax.config.settings import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

    from tests.capture.file.conftest import MakeClip

    from wax.capture.source import Picture

    Send = Callable[[bytes], object]

CLOCK = SystemClock()
SIZE = VideoSettings(width=160, height=120)
BITS = 8
CUT = b"\r\n--cut\r\n"


def jpeg(number: int) -> bytes:
    """Return a picture that says its number, in black and white bars."""
    bars = [255 * (number >> bit & 1) for bit in range(BITS)]
    row = np.repeat(np.array(bars, np.uint8), 160 // BITS)
    return cv2.imencode(".jpg", np.tile(row, (120, 1)))[1].tobytes()


def number_of(picture: Picture) -> int:
    """Read what `jpeg` wrote."""
    row = picture.i420[60, : picture.width].reshape(BITS, -1).mean(axis=1)
    return sum(int(grey > 128) << bit for bit, grey in enumerate(row))


@contextmanager
def serving(answer: Callable[[Send], None]) -> Iterator[str]:
    """Answer each request by HTTP with what `answer` sends."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            with suppress(OSError):
                while self.rfile.readline().strip():
                    pass
                answer(self.wfile.write)

    class Server(socketserver.ThreadingTCPServer):
        daemon_threads = True
        block_on_close = False

    with Server(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/cam"
        finally:
            server.shutdown()
            thread.join()


def watch(address: str, duration_s: float) -> list[tuple[Picture, float]]:
    """Return the pictures of so long, each with when it was handed over."""
    source = MediaFile(address, CLOCK).video(SIZE)
    source.open()
    seen = []
    try:
        end_s = CLOCK.now_s() + duration_s
        while CLOCK.now_s() < end_s:
            seen.append((source.read(), CLOCK.now_s()))
    finally:
        source.close()
    return seen


def multipart(
    pictures: Iterable[bytes], fps: float, taken_s: list[float], *, first: bytes = CUT
) -> Callable[[Send], None]:
    """Return an answer of parts with their lengths; `first` is before the first one."""

    def answer(send: Send) -> None:
        send(b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=cut\r\n\r\n")
        boundary = first
        for content in pictures:
            taken_s.append(CLOCK.now_s())
            head = f"Content-Type: image/jpeg\r\nContent-Length: {len(content)}\r\n\r\n"
            send(boundary + head.encode() + content)
            boundary = CUT
            time.sleep(1 / fps)

    return answer


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the first second and a second of repetitions be short."""
    monkeypatch.setattr("wax.capture.dating._SETTLE_S", 0.2)
    monkeypatch.setattr("wax.capture.dating._REPEATED_S", 0.2)


@pytest.mark.usefixtures("soon")
def test_multipart_jpeg_is_as_old_as_it_is() -> None:
    """A camera of 10 pictures a second, which FFmpeg stamps as 25: each age is right to 60 ms."""
    taken_s: list[float] = []
    with serving(multipart(map(jpeg, range(150)), 10, taken_s)) as address:
        seen = watch(address, 0.9)
    assert len(seen) > 7
    for picture, _ in seen[1:]:
        assert picture.captured_s - taken_s[number_of(picture)] == pytest.approx(0.03, abs=0.06)
    assert seen[0][0].within_s is None  # it may be the last one of yesterday
    assert seen[-1][0].within_s is not None


def test_a_camera_that_forgets_its_first_boundary_is_shown() -> None:
    """Some boards begin with a part's head; each picture is known once the next one has begun."""
    taken_s: list[float] = []
    with serving(multipart(map(jpeg, range(150)), 30, taken_s, first=b"")) as address:
        seen = watch(address, 0.3)
    errors_s = [picture.captured_s - taken_s[number_of(picture)] for picture, _ in seen[3:]]
    assert errors_s == pytest.approx([0.03] * len(errors_s), abs=0.06)
    assert len(errors_s) > 3


def test_a_page_is_no_camera() -> None:
    """An address that answers with words is said to be nothing to play."""

    def answer(send: Send) -> None:
        send(b"HTTP/1.0 200 OK\r\nContent-Length: 13\r\n\r\n<p>Log in</p>")

    with serving(answer) as address, pytest.raises(SourceError, match="is not a playable"):
        open_container(address)


@pytest.mark.usefixtures("soon")
def test_a_picture_that_is_repeated_is_not_new() -> None:
    """A server whose camera hangs sends its last picture on: watched by many, driven by nobody."""
    pictures = (jpeg(min(number, 15)) for number in range(150))
    with serving(multipart(pictures, 40, [])) as address:
        seen = watch(address, 0.9)
    known = [number_of(picture) for picture, _ in seen if picture.within_s is not None]
    repeated = [picture for picture, _ in seen if number_of(picture) == 15]
    assert known.count(15) == 1
    assert known[0] > 3
    assert len(repeated) > 1


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


def test_a_bare_stream_is_dated_by_its_arrival() -> None:
    """H.264 without a container: a picture is one period old when the next one ends it."""
    frames = coded(30)

    def answer(send: Send) -> None:
        send(b"HTTP/1.1 200 OK\r\nContent-Type: video/h264\r\n\r\n")
        for frame in frames * 6:
            send(frame)
            time.sleep(1 / 60)

    with serving(answer) as address:
        seen = watch(address, 0.3)
    ages_s = [at_s - picture.captured_s for picture, at_s in seen]
    assert len(ages_s) > 3
    # What came while FFmpeg looked at the stream is read all at once, by a busy machine too.
    assert 0.015 < statistics.median(ages_s) < 0.2, ages_s


@pytest.mark.parametrize("length", [True, False])
def test_a_snapshot_is_nobodys(*, length: bool) -> None:
    """One JPEG that is asked for again and again, with a length or without, is never known."""
    content = jpeg(9)

    def answer(send: Send) -> None:
        told = f"Content-Length: {len(content)}\r\n" if length else ""
        send(f"HTTP/1.0 200 OK\r\nContent-Type: image/jpeg\r\n{told}\r\n".encode() + content)

    with serving(answer) as address:
        seen = watch(address, 0.1)
    assert seen
    assert all(picture.within_s is None for picture, _ in seen)


def test_a_film_by_http_is_nobodys_and_a_file_is_ours(make_clip: MakeClip) -> None:
    """The same film: from elsewhere it is of unknown age, from this machine a demonstration."""
    clip = make_clip("a.ts", audio=None, seconds=0.5)
    content = clip.read_bytes()

    def answer(send: Send) -> None:
        send(f"HTTP/1.0 200 OK\r\nContent-Length: {len(content)}\r\n\r\n".encode() + content)

    with serving(answer) as address:
        assert watch(address, 0.05)[0][0].within_s is None
    assert watch(str(clip), 0.05)[0][0].within_s == 0.0


def test_segments_are_nobodys(make_clip: MakeClip, tmp_path: Path) -> None:
    """A playlist of HLS is late by its segments, wherever it lies."""
    make_clip("a.ts", audio=None, seconds=0.5)
    playlist = tmp_path / "live.m3u8"
    playlist.write_text("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:0.5,\na.ts\n#EXT-X-ENDLIST\n")
    assert watch(str(playlist), 0.05)[0][0].within_s is None


def test_a_picture_file_is_nobodys(tmp_path: Path) -> None:
    """Another program may write it anew, or have stopped to do so."""
    path = tmp_path / "snapshot.jpg"
    path.write_bytes(jpeg(3))
    assert watch(str(path), 0.1)[0][0].within_s is None
