"""The connection through a rosbridge server, with an event loop in a thread of its own."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import math
import socket
import struct
import termios
import threading
from collections import deque
from typing import TYPE_CHECKING, Any, Final

import aiohttp
import structlog

from wax.as_written import as_written
from wax.errors import DriverError, reason_of
from wax.logs.printable import shown_url
from wax.robot.ros2 import rosbridge_protocol as protocol
from wax.robot.ros2.link import command_type
from wax.robot.ros2.rosbridge_graph import RosbridgeGraph
from wax.robot.ros2.standby_rules import SILENCE_S
from wax.second_look import explained
from wax.sentence import Sentence
from wax.unreachable import Target

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.driver.interface import Twist
    from wax.robot.ros2.command_topic import Traffic
    from wax.robot.ros2.link import Wanted
    from wax.robot.ros2.settings import Ros2Settings

_LOG = structlog.get_logger(__name__)

CONNECT_S: Final = 3.0
LOOK_S: Final = 1.0
BEAT_S: Final = 2.0
"""The ping interval; a server that does not answer within half of it counts as lost."""
TICK_S: Final = 0.1
CLOSE_S: Final = 0.3
MAX_WAITING_BYTES: Final = 8192
"""Less than a second of set-points: no more may be queued here while the network is down."""
MAX_MESSAGE_BYTES: Final = 1_000_000
"""Messages other than pictures are smaller; reading larger ones would delay the commands."""
MAX_PICTURE_BYTES: Final = 8_000_000
"""The limit for a link that only subscribes, such as the camera's."""
THROTTLE_MS: Final = {"odometry": 50}
_KEPT: Final = 8
_MAX_REFUSED: Final = 16


class RosbridgeLink:
    """A `Link` to one rosbridge server; it advertises if it has a `mark`."""

    def __init__(
        self,
        settings: Ros2Settings,
        clock: Clock,
        *,
        mark: str = "",
        wanted: Sequence[Wanted] = (),
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._publishes = bool(mark)
        self._most_bytes = MAX_MESSAGE_BYTES if mark else MAX_PICTURE_BYTES
        self._wanted = {want.topic: want for want in wanted}
        self._graph = RosbridgeGraph(settings.topic, settings.rosbridge_node)
        self._news = threading.Condition()
        self._heard: dict[str, deque[Any]] = {}
        self._error: Sentence | None = None
        self._connected = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._wake = asyncio.Event()
        self._closing = False
        self._words: deque[str] = deque()
        self._refused: set[str] = set()
        self._command: tuple[str, float] | None = None
        self._thread = threading.Thread(target=self._run, name="rosbridge", daemon=True)
        self._thread.start()
        self._connected.wait()
        if self._error is not None:
            self.close()  # it may have connected and been refused meanwhile
            raise DriverError(self._error)

    @property
    def guid(self) -> str:
        return ""

    def send(self, twist: Twist, wall_ns: int) -> None:
        self._check()
        if self._publishes:
            stamp = (wall_ns, self._settings.frame_id) if self._settings.stamped else None
            until_s = math.inf if twist.is_zero else self._clock.now_s() + SILENCE_S
            # Replace an unsent set-point: only the newest counts.
            self._command = protocol.publish(self._settings.topic, twist, stamp=stamp), until_s
            self._call(self._wake.set)

    def take(self, timeout_s: float) -> list[tuple[str, Any]]:
        with self._news:
            self._news.wait_for(lambda: self._heard or self._error, timeout_s)
            heard, self._heard = self._heard, {}
        self._check()
        return [(kind, message) for kind, messages in heard.items() for message in messages]

    def traffic(self) -> Traffic:
        self._check()
        with self._news:
            return self._graph.traffic(self._clock.now_s())

    def close(self) -> None:
        self._closing = True
        self._call(self._wake.set)
        self._thread.join(CLOSE_S + 0.1)

    def _check(self) -> None:
        if self._error is not None:
            raise DriverError(self._error)

    def _call(self, what: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(what)

    # --- in the thread -----------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._live())
        except (aiohttp.ClientError, OSError, TimeoutError, ValueError) as error:
            self._fail(self._why(error))
        except Exception as error:
            # Without this thread nothing is sent, so a failure must be reported.
            _LOG.exception("the link to the rosbridge server failed")
            self._fail(self._lost(type(error).__name__))
        finally:
            self._loop.close()
            self._connected.set()

    async def _live(self) -> None:
        async with aiohttp.ClientSession(read_bufsize=self._most_bytes) as session:
            async with asyncio.timeout(CONNECT_S):
                line = await session.ws_connect(
                    as_written(self._settings.rosbridge_url),
                    heartbeat=BEAT_S,
                    max_msg_size=self._most_bytes,
                    timeout=aiohttp.ClientWSTimeout(ws_close=CLOSE_S),
                )
            self._introduce()
            listener = asyncio.ensure_future(self._listen(line))
            try:
                self._connected.set()
                await self._speak(line, listener)
            finally:
                listener.cancel()
                await asyncio.gather(listener, return_exceptions=True)
                with contextlib.suppress(aiohttp.ClientError, TimeoutError):
                    await line.close()

    def _introduce(self) -> None:
        if self._publishes:
            self._words.append(
                protocol.advertise(self._settings.topic, command_type(self._settings))
            )
        for want in self._wanted.values():
            throttle_ms = THROTTLE_MS.get(want.kind, 0)
            self._words.append(
                protocol.subscribe(want.topic, want.type_name, throttle_ms=throttle_ms)
            )

    async def _speak(
        self, line: aiohttp.ClientWebSocketResponse, listener: asyncio.Future[None]
    ) -> None:
        while not listener.done():
            self._words += self._graph.questions(self._clock.now_s()) if self._publishes else ()
            while self._words:
                await line.send_str(self._words.popleft())
            command, self._command = self._command, None
            # After a freeze the standby may have stopped the robot: old motion must not undo it.
            if command is not None and self._clock.now_s() < command[1]:
                _refuse_to_pile_up(line)
                await line.send_str(command[0])
            if self._closing:
                return
            if self._command is None:
                self._wake.clear()
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._wake.wait(), TICK_S)
        listener.result()  # re-raises its exception
        self._fail(self._lost("it hung up"))

    async def _listen(self, line: aiohttp.ClientWebSocketResponse) -> None:
        async for frame in line:
            if frame.type is aiohttp.WSMsgType.ERROR:  # no answer to a ping, or too large a message
                raise ValueError(str(frame.data))
            if frame.type is not aiohttp.WSMsgType.TEXT:
                continue
            try:
                heard = protocol.read(frame.data)
            except ValueError:
                continue  # ignore invalid messages
            with self._news:
                self._take(heard)
                self._news.notify_all()
        self._wake.set()

    def _take(self, heard: protocol.Heard | None) -> None:
        match heard:
            case protocol.Published():
                want = self._wanted.get(heard.topic)
                if want is not None:
                    self._heard.setdefault(want.kind, deque(maxlen=_KEPT)).append(heard.message)
            case protocol.ServiceAnswer():
                self._graph.handle_answer(heard, self._clock.now_s())
            case protocol.Complaint() if self._publishes and heard.is_harmless:
                self._note(heard)
            case protocol.Complaint():
                self._error = Sentence("ros2.bridge_refuses", {"why": heard.words.rstrip(".")})

    def _note(self, refused: protocol.Complaint) -> None:
        """Log each refusal once; the refused data stay unknown, but the robot is connected."""
        if refused.about not in self._refused and len(self._refused) < _MAX_REFUSED:
            self._refused.add(refused.about)
            _LOG.warning("the rosbridge server refuses; the rest goes on", why=refused.words)

    def _why(self, error: Exception) -> Sentence:
        if self._connected.is_set():
            return self._lost(reason_of(error))
        url = self._settings.rosbridge_url
        shown = shown_url(url)
        if isinstance(error, aiohttp.WSServerHandshakeError):
            return Sentence("ros2.no_websocket", {"url": shown, "status": error.status})
        target = Target.of(url, CONNECT_S)
        if target is None:
            told = Sentence("unreachable.not_possible")
        else:
            told = explained(target, error, LOOK_S)
        return Sentence("ros2.no_bridge", {"url": shown, "why": told})

    def _lost(self, why: str) -> Sentence:
        shown = shown_url(self._settings.rosbridge_url)
        return Sentence("ros2.bridge_lost", {"url": shown, "why": why})

    def _fail(self, why: Sentence) -> None:
        with self._news:
            self._error = self._error or why
            self._news.notify_all()


def _refuse_to_pile_up(line: aiohttp.ClientWebSocketResponse) -> None:
    """Drop a stalled connection and its queue, whose messages would arrive too late."""
    sock = line.get_extra_info("socket")
    if sock is not None and _waiting_bytes(sock) > MAX_WAITING_BYTES:
        # Closing then discards the system's send buffer.
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        raise TimeoutError("it takes nothing")


def _waiting_bytes(sock: socket.socket) -> int:
    """Return the bytes sent but not acknowledged, 0 if the system does not say."""
    found = struct.pack("i", 0)
    with contextlib.suppress(OSError):
        found = fcntl.ioctl(sock.fileno(), termios.TIOCOUTQ, found)
    (waiting,) = struct.unpack("i", found)
    return int(waiting)
