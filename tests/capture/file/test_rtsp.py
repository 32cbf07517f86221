"""RTSP cameras: GStreamer's server as the real counterpart, and some that misbehave."""

from __future__ import annotations

import os
import signal
import socketserver
import subprocess
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import pytest
from structlog.testing import capture_logs
from tests.free_port import free_port

from wax import device_thread
from wax.capture.file import address
from wax.capture.file.address import Transport, open_container
from wax.capture.file.media_file import MediaFile
from wax.capture.source_thread import SourceThread
from wax.clock import SystemClock
from wax.config.audio import AudioSettings
from wax.config.video import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.capture.source import Picture

PYTHON = "/usr/bin/python3"
PROGRAM = Path(__file__).with_name("rtsp_server.py")
SIZE = VideoSettings(width=320, height=240)
SECRET = "s3cr%40t"  # percent-encoded in an address
CLOCK = SystemClock()


def _is_there() -> bool:
    look = "import gi; gi.require_version('GstRtspServer', '1.0')"
    try:
        done = subprocess.run([PYTHON, "-c", look], capture_output=True, check=False)
    except OSError:
        return False
    return done.returncode == 0


REAL = pytest.mark.skipif(
    not _is_there(),
    reason="no RTSP server; on Debian: apt install python3-gi gir1.2-gst-rtsp-server-1.0"
    " gstreamer1.0-plugins-good gstreamer1.0-plugins-ugly",
)
pytestmark = pytest.mark.system


class RealServer:
    """GStreamer's RTSP server in a process of its own."""

    def __init__(self, *password: str) -> None:
        self._password = password
        self.port = free_port()
        self.url = f"rtsp://127.0.0.1:{self.port}"
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = subprocess.Popen(
            [PYTHON, str(PROGRAM), str(self.port), *self._password],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"

    def freeze(self) -> None:
        assert self._process is not None
        os.kill(self._process.pid, signal.SIGSTOP)

    def kill(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()


@pytest.fixture
def server() -> Iterator[RealServer]:
    yield from _serving(RealServer())


@pytest.fixture
def locked() -> Iterator[RealServer]:
    yield from _serving(RealServer("me", "s3cr@t"))


def _serving(real: RealServer) -> Iterator[RealServer]:
    try:
        real.start()
        yield real
    finally:
        real.kill()


def until(holds: Callable[[], bool], within_s: float) -> float:
    """Wait until the condition holds, and return how long that took."""
    began_s = time.monotonic()
    while not holds():
        assert time.monotonic() - began_s < within_s, "it never happened"
        time.sleep(0.02)
    return time.monotonic() - began_s


@REAL
@pytest.mark.alone
@pytest.mark.parametrize(
    "transport",
    [
        pytest.param("auto", marks=pytest.mark.full),
        "tcp",
        pytest.param("udp", marks=pytest.mark.full),
    ],
)
def test_the_newest_picture_is_shown(server: RealServer, transport: Transport) -> None:
    """By TCP and UDP, a reader that was away for 1 s gets no old picture, then all new ones."""
    source = MediaFile(f"{server.url}/cam", CLOCK, transport=transport).video(SIZE)
    source.open()
    try:
        for _ in range(10):
            source.read()
        time.sleep(1.0)
        late = source.read()
        assert CLOCK.now_s() - late.captured_s < 0.3
        pictures = [source.read() for _ in range(30)]
        assert 0.7 < pictures[-1].captured_s - late.captured_s < 1.5
        assert CLOCK.now_s() - pictures[-1].captured_s < 0.3
        assert pictures[-1].width == 320
        assert pictures[-1].within_s is not None
    finally:
        source.close()


@REAL
def test_sound_comes_from_the_same_camera(server: RealServer) -> None:
    """Picture and sound share one connection."""
    media = MediaFile(f"{server.url}/cam", CLOCK)
    video, audio = media.video(SIZE), media.audio(AudioSettings())
    video.open()
    audio.open()
    try:
        heard = [audio.read() for _ in range(20)]
        assert any(one.samples.any() for one in heard)
        assert video.read().width == 320
    finally:
        video.close()
        audio.close()


@REAL
def test_it_comes_back_by_itself(locked: RealServer) -> None:
    """The problem names a lost camera's host without the password until it reconnects by itself."""
    pictures: list[Picture] = []
    media = MediaFile(f"rtsp://me:{SECRET}@127.0.0.1:{locked.port}/cam", CLOCK)
    thread = SourceThread(media.video(SIZE), pictures.append, name="camera", clock=CLOCK)
    with capture_logs() as logs:
        thread.start()
        try:
            until(lambda: len(pictures) > 20, 20)
            locked.kill()
            until(lambda: thread.problem is not None, 20)
            said = str(thread.problem)
            assert f"rtsp://127.0.0.1:{locked.port}/cam" in said
            time.sleep(2)
            assert thread.problem is not None
            locked.start()
            count = len(pictures)
            until(lambda: len(pictures) > count + 20, 20)
            until(lambda: thread.problem is None, 20)
        finally:
            thread.stop()
    assert logs
    assert "s3cr" not in said + str(logs)


@REAL
@pytest.mark.alone
def test_one_that_freezes_is_noticed(server: RealServer) -> None:
    """A read fails 3 s after the last picture when nothing arrives on an open connection."""
    source = MediaFile(f"{server.url}/cam", CLOCK).video(SIZE)
    source.open()
    try:
        source.read()
        server.freeze()
        came_s = [time.monotonic()]

        def read() -> bool:  # packets that had arrived are still read
            source.read()
            came_s.append(time.monotonic())
            return True

        with pytest.raises(SourceError, match=r"127\.0\.0\.1:\d+/cam"):
            list(iter(read, False))
        assert time.monotonic() - came_s[-1] < 3
    finally:
        source.close()


@REAL
@pytest.mark.parametrize("who", ["", "me:wrong@", f"you:{SECRET}@"])
def test_a_wrong_password_is_said(locked: RealServer, who: str) -> None:
    """For a missing or wrong login the sentence says what to write, without the password."""
    with pytest.raises(SourceError, match="refuses the user name or the password") as caught:
        open_container(f"rtsp://{who}127.0.0.1:{locked.port}/cam")
    assert "wrong" not in str(caught.value)
    assert caught.value.__cause__ is None
    assert caught.value.__suppress_context__


@REAL
def test_a_wrong_path_is_said(server: RealServer) -> None:
    """The sentence for a path that the camera does not have says so."""
    with pytest.raises(SourceError, match="has no such stream"):
        open_container(f"{server.url}/nothing")


class Answering(socketserver.StreamRequestHandler):
    """Gives each request the same answer, or none."""

    answer = b""
    came: ClassVar[list[float]] = []

    def handle(self) -> None:
        self.came.append(time.monotonic())
        with suppress(OSError):
            for line in self.rfile:
                if self.answer and line.startswith(b"CSeq: "):
                    self.wfile.write(self.answer.replace(b"NUMBER", line[6:].strip()))


@contextmanager
def listening(answer: bytes) -> Iterator[tuple[str, list[float]]]:
    """Accept connections and answer each request so; yield the address and connection times."""
    came: list[float] = []
    handler = type("Handler", (Answering,), {"answer": answer, "came": came})
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"127.0.0.1:{server.server_address[1]}", came
        finally:
            server.shutdown()
            thread.join()


def test_one_that_never_answers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A camera that accepts but never answers fails after a bounded time."""
    monkeypatch.setattr(address, "_TIMEOUT_S", (0.5, 0.5))
    with listening(b"") as (host, _):
        began_s = time.monotonic()
        with pytest.raises(SourceError, match=r"does not answer within 0\.5 s"):
            open_container(f"rtsp://{host}/cam")
        assert time.monotonic() - began_s < 3


REFUSES = (
    b"RTSP/1.0 401 Unauthorized\r\nCSeq: NUMBER\r\n"
    b'WWW-Authenticate: Basic realm="cam"\r\nContent-Length: 0\r\n\r\n'
)
BREAKS = b"RTSP/1.0 500 Internal Server Error\r\nCSeq: NUMBER\r\nContent-Length: 0\r\n\r\n"


@pytest.mark.parametrize(
    ("answer", "most"), [(REFUSES, 1), pytest.param(BREAKS, 3, marks=pytest.mark.full)]
)
def test_it_is_not_asked_too_often(
    answer: bytes, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In 4 s there is a bounded number of connections; meanwhile the page says what is wrong."""
    with listening(answer) as (host, came):
        media = MediaFile(f"rtsp://me:{SECRET}@{host}/cam", CLOCK)
        monkeypatch.setattr(device_thread, "_RETRY_S", 0.1)
        thread = SourceThread(media.video(SIZE), lambda _: None, name="camera", clock=CLOCK)
        thread.start()
        try:
            until(lambda: thread.problem is not None, 20)
            time.sleep(4)
            assert host in str(thread.problem)
            assert "s3cr" not in str(thread.problem)
            assert 1 <= len(came) <= most
        finally:
            thread.stop()
