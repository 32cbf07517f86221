"""Stream addresses: a live one never builds up delay, and no name gives a password away."""

from __future__ import annotations

import socket
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.free_port import free_port

from wax.capture.file.address import shown_name
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
            while not player.video.demuxer.failed:  # it has come as a whole
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
    """An unreachable stream is named without its password, with what to do."""
    port = free_port()
    with pytest.raises(SourceError) as caught:
        open_player(f"http://me:secret@127.0.0.1:{port}/live?token=abc").__enter__()
    assert f"http://127.0.0.1:{port}/live cannot be opened. Nobody listens" in str(caught.value)
    # It may be there, and taken by this configuration itself.
    assert "another source of this configuration" in str(caught.value)
    assert "secret" not in str(caught.value)
    assert "abc" not in str(caught.value)


def test_names_that_people_see_have_no_password() -> None:
    """Of an address host and path are shown, of a file its name."""
    assert shown_name("rtsp://u:p@cam.example:554/a?k=v") == "rtsp://cam.example:554/a"
    assert shown_name("/home/me/clip.mp4") == "clip.mp4"
