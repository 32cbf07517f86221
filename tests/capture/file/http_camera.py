"""A camera that answers by HTTP, with real bytes on a real connection."""

from __future__ import annotations

import socketserver
import threading
import time
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    Send = Callable[[bytes], object]

CLOCK = SystemClock()
CUT = b"\r\n--cut\r\n"


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


def multipart(
    pictures: Iterable[bytes], fps: float, taken_s: list[float], *, first: bytes = CUT
) -> Callable[[Send], None]:
    """Return a response of parts with their lengths; `first` precedes the first one."""

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
