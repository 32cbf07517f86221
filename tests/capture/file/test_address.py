"""Stream addresses: a live one never builds up delay, and no name gives a password away."""

from __future__ import annotations

import hashlib
import socket
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import StreamRequestHandler, ThreadingTCPServer
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.free_port import free_port

from wax.capture.file.address import open_container, shown_name
from wax.errors import SourceError

if TYPE_CHECKING:
    from tests.capture.file.conftest import MakeClip, Player

    from wax.capture.source import Picture


def test_a_live_stream_never_builds_up_delay(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """When 3 s of a live stream arrive at once, only the newest is shown; its end is an error."""
    clip = make_clip("a.ts", seconds=3)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            peer, _ = server.accept()
            with peer:
                peer.sendall(clip.read_bytes())

        thread = threading.Thread(target=serve)
        thread.start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        pictures: list[Picture] = []
        with open_player(address, audio=False) as player:
            assert player.video is not None
            thread.join(timeout=5)
            while not player.video.demuxer.failed:  # all of it has arrived
                time.sleep(0.005)
            with pytest.raises(SourceError, match="has ended; waiting for it to come back"):
                pictures.extend(iter(player.video.read, None))
    assert all(picture.captured_s <= 500.0 for picture in pictures)
    assert len(pictures) == 1
    assert player.clock.now_s() == 500.0


def test_a_file_behind_http_is_played_like_a_file(
    make_clip: MakeClip, open_player: type[Player]
) -> None:
    """A film on a plain web server plays at its own speed, again and again, in step."""
    content = make_clip("a.ts", seconds=2).read_bytes()

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
            with open_player(f"http://127.0.0.1:{server.server_port}/a.ts") as player:
                player.play(6.3)
        finally:
            server.shutdown()
            thread.join()
    flashes, beeps = player.flashes(), player.beeps()
    assert len(flashes) == len(beeps) == 6
    assert np.abs(np.subtract(beeps, flashes)).max() < 0.020


def test_an_address_that_nobody_answers_is_one_sentence(open_player: type[Player]) -> None:
    """The error for an unreachable stream names it without its password and says what to do."""
    port = free_port()
    with pytest.raises(SourceError) as caught:
        open_player(f"http://me:secret@127.0.0.1:{port}/live?token=abc").__enter__()
    assert f"http://127.0.0.1:{port}/live cannot be opened. Nobody listens" in str(caught.value)
    # The port may be open and used by this configuration itself.
    assert "another source of this configuration" in str(caught.value)
    assert "secret" not in str(caught.value)
    assert "abc" not in str(caught.value)


@pytest.mark.parametrize(
    ("challenge", "said"),
    [
        ('Basic realm="x"', "Basic bUBlOnBAc3MvKw=="),
        ('Digest realm="x", nonce="1"', 'username="m@e"'),
    ],
)
@pytest.mark.parametrize("scheme", ["http", "rtsp"])
def test_a_cameras_address_is_asked_for_as_written(scheme: str, challenge: str, said: str) -> None:
    """The path is requested undecoded, as signed addresses need; name and password are decoded."""
    heads: list[str] = []

    class Handler(StreamRequestHandler):
        """Asks for a password, then has no such file."""

        def handle(self) -> None:
            head = ""
            while line := self.rfile.readline().decode():
                head += line
                if line != "\r\n":
                    continue
                heads.append(head)
                status = "404 Not Found" if "Authorization:" in head else "401 Unauthorized"
                answer = (
                    f"{'RTSP' if scheme == 'rtsp' else 'HTTP'}/1.0 {status}\r\nCSeq: {len(heads)}"
                )
                answer += f"\r\nWWW-Authenticate: {challenge}\r\nContent-Length: 0\r\n\r\n"
                self.wfile.write(answer.encode())
                head = ""

    path = "/a%2Fb%20c/x%3D?sig=A%2Fd%2Be%3D&&q=a+b%20c&e="
    with ThreadingTCPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        at = f"127.0.0.1:{server.server_address[1]}"
        try:
            with pytest.raises(SourceError, match="no such stream"):
                open_container(f"{scheme}://m%40e:p%40ss%2F+@{at}{path}")
        finally:
            server.shutdown()
            thread.join()
    asked = f"rtsp://{at}{path}" if scheme == "rtsp" else path
    assert {head.split()[1] for head in heads} == {asked}
    assert said in heads[-1]
    if challenge.startswith("Digest"):  # RFC 2617, 3.2.2.1
        method = heads[-1].split()[0]
        whose, what = (_md5(text) for text in ("m@e:x:p@ss/+", f"{method}:{asked}"))
        assert f'response="{_md5(f"{whose}:1:{what}")}"' in heads[-1]


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


def test_names_that_people_see_have_no_password() -> None:
    """People see only an address's host and path, and a file's name."""
    assert shown_name("rtsp://u:p@cam.example:554/a?k=v") == "rtsp://cam.example:554/a"
    assert shown_name("/home/me/clip.mp4") == "clip.mp4"
