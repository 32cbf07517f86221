"""A viewer without a browser: connects, watches, and sends what a page sends."""

from __future__ import annotations

import asyncio
import json
import random
import time
import uuid
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, Self

import aiohttp
from aiortc import RTCConfiguration, RTCIceServer, RTCPeerConnection, RTCSessionDescription
from pydantic_core import from_json

from wax.client.clock import ServerClock
from wax.client.media import Media
from wax.client.receipts import Receipts
from wax.client.reports import INTERVAL_S, ReceivedStream, Reporter
from wax.client.sdp import as_browser
from wax.errors import SignallingError
from wax.protocol import compact, messages, room_change

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from types import TracebackType

    from aiortc import RTCDataChannel

    from wax.client.rtp_header import RtpHeader
    from wax.client.sdp import Kind

_CONNECT_S: Final = 15.0
_HTTP_S: Final = 10.0
_ANSWERED: Final = 64
_ATTEMPTS: Final = 20
_AGAIN_S: Final = (0.1, 0.5)
_SOON: Final = ("1", "2", "3")

# The page's heartbeat (`link/heartbeat.ts`).
_EAGER_S: Final = 1.0
_EAGER_PONGS: Final = 6
_EAGER_PAUSE_S: Final = 0.05
_KEEN_PAUSE_S: Final = 0.2
_CALM_PAUSE_S: Final = 1.0


class Client:
    """One peer from `connect` to `close`; an async context manager does both."""

    is_keen = False
    """Whether it sends several heartbeats a second, as a page that drives or waits to drive."""
    decodes = False
    """As in `Media`."""
    size: str | None = None
    """The size it wants; without one, or if the server lacks it, it gets the largest."""

    def __init__(
        self,
        url: str,
        *,
        # Tells a reloaded page from that browser's other tabs.
        client_id: str | None = None,
        name: str | None = None,
        # The browser that the server recognises; without them it is one of its own.
        cookies: aiohttp.CookieJar | None = None,
        # Sent with each request, as a proxy would add them.
        headers: Mapping[str, str] | None = None,
        # Its first wishes.
        sound: bool = True,
        picture: bool = True,
        # Gets each message of the state channel.
        on_message: Callable[[dict[str, Any]], None] | None = None,
        # As in `Media`.
        on_socket: Callable[[Any], None] | None = None,
        # As a browser wants them, for a server that is not reached by one port.
        ice_servers: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        self.client_id = client_id or str(uuid.uuid4())
        # aiohttp calls cookies for an IP address "unsafe".
        self.cookies = aiohttp.CookieJar(unsafe=True) if cookies is None else cookies
        self.clock = ServerClock()
        servers = [RTCIceServer(**one) for one in ice_servers]
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=servers))
        self.media = Media(
            self.peer, on_packet=self._acknowledge, on_socket=on_socket, decodes=self.decodes
        )
        self.state: RTCDataChannel = self.peer.createDataChannel("state")
        self.drive: RTCDataChannel = self.peer.createDataChannel(
            "drive", ordered=False, maxRetransmits=0
        )
        self._url = url
        self._name = name
        self._headers = headers
        self._wants = {"sound": sound, "picture": picture}
        self._on_message = on_message
        self._http: aiohttp.ClientSession | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._newest: dict[str, dict[str, Any]] = {}
        self._news = asyncio.Event()
        self._pings = 0
        self._pong: tuple[int, float] | None = None
        self._answered: deque[int] = deque(maxlen=_ANSWERED)
        self.beat: str | None = None
        """The newest beat heard, for the next command."""
        self._receipts: Receipts | None = None
        self._reporter = Reporter()
        self.state.on("message", self._heard)
        self.drive.on("message", self._heard_drive)

    async def __aenter__(self) -> Self:
        try:
            await self.connect()
        except BaseException:
            await self.close()
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def connect(self) -> None:
        """Return when both channels are open and the server has greeted.

        Raises `SignallingError`, `TimeoutError` or `aiohttp.ClientError`.
        """
        await self.peer.setLocalDescription(await self.peer.createOffer())
        answer = await self._exchange(as_browser(self.peer.localDescription.sdp))
        await self.peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        self.media.attach(answer)
        for channel in (self.state, self.drive):
            channel.on("open", self._news.set)
            channel.on("close", self._news.set)
        if not await self.until(lambda: self.is_open, _CONNECT_S):
            raise TimeoutError(f"{self._url}: the connection is {self.peer.connectionState}")
        self._greet()
        self._start(self._beat(), "heartbeat")
        self._start(self._report(), "report")

    async def close(self) -> None:
        """Leave as a closed page does; safe to call twice."""
        tasks, self._tasks = self._tasks, []
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if self._http is not None:
            await self._http.close()
        await self.peer.close()
        await self.media.close()

    # --- what the server says -----------------------------------------------------------------

    @property
    def is_open(self) -> bool:
        """Both channels are open, and the server has greeted."""
        is_open = self.state.readyState == self.drive.readyState == "open"
        return is_open and "hello" in self._newest

    def newest(self, kind: str) -> dict[str, Any]:
        """Return the newest message of this type on the state channel, empty before the first."""
        return self._newest.get(kind, {})

    def age_ms(self, kind: Kind) -> float | None:
        """Return the newest frame's age on arrival; None before its stream's clock is known."""
        newest = self.media.newest(kind)
        if newest is None:
            return None
        return self._reporter.age_ms(kind, newest, self.clock.ahead_ms)

    async def until(self, holds: Callable[[], bool], within_s: float | None = 5.0) -> bool:
        """Wait until a message or a channel's end makes it true; return False after a timeout.

        A timeout of None waits for ever.
        """
        with suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                while not holds():
                    self._news.clear()
                    await self._news.wait()
        return holds()

    def captured_ms(self, kind: Kind, rtp: int) -> float | None:
        """Return when it was captured by the server's clock; None before that stream's is known."""
        return self._reporter.captured_ms(kind, rtp)

    def server_ms(self) -> float:
        """Return the server's clock in ms, accurate to half a round trip."""
        return _now_ms() + self.clock.ahead_ms

    # --- what it says -------------------------------------------------------------------------

    def send(self, **message: Any) -> None:
        """Send any message on the state channel."""
        self.state.send(json.dumps(message))

    async def post(self, path: str, body: Mapping[str, Any]) -> dict[str, Any]:
        """Send an HTTP request as this client; raises `SignallingError` if the server refuses."""
        if self._http is None:
            timeout = aiohttp.ClientTimeout(total=_HTTP_S)
            self._http = aiohttp.ClientSession(
                timeout=timeout, cookie_jar=self.cookies, headers=self._headers
            )
        asked = {"client": self.client_id, **body}
        for attempt in range(1, _ATTEMPTS + 1):
            async with self._http.post(self._url + path, json=asked) as response:
                text = await response.text()
            # Others may be connecting at the same moment: then the server says when to retry.
            again_s = response.headers.get("Retry-After")
            if again_s not in _SOON or attempt == _ATTEMPTS:
                break
            await asyncio.sleep(random.uniform(*_AGAIN_S) * float(again_s))
        if response.status != 200:
            raise SignallingError(f"{self._url}{path}: {response.status} {text[:200]}")
        try:
            answer = from_json(text)
        except ValueError:
            answer = None
        if not isinstance(answer, dict):
            raise SignallingError(f"{self._url}{path}: the answer is not one of WAX")
        return answer

    def ping(self) -> int:
        """Send a heartbeat; returns its number."""
        self._pings += 1
        now_ms = _now_ms()
        number, came_ms = self._pong or (None, None)
        ping = messages.Ping(
            type="ping",
            id=self._pings,
            sent_page_ms=now_ms,
            pong_id=number,
            pong_held_ms=None if came_ms is None else now_ms - came_ms,
        )
        self.drive.send(compact.write(ping))
        return self._pings

    async def pongs(self, within_s: float = 1.0) -> bool:
        """Send pings, since the channel may lose any; return whether one is answered in time."""
        sent: set[int] = set()
        end_s = time.monotonic() + within_s
        while (left_s := end_s - time.monotonic()) > 0:
            sent.add(self.ping())
            if await self.until(
                lambda: not sent.isdisjoint(self._answered), min(left_s, _KEEN_PAUSE_S)
            ):
                return True
        return False

    # --- inside -------------------------------------------------------------------------------

    async def _exchange(self, offer: str) -> str:
        return str((await self.post("/api/offer", {"sdp": offer}))["sdp"])

    def _greet(self) -> None:
        if self._name is not None:
            self.send(type="name", name=self._name)
        sizes = self.newest("hello")["sizes"]
        size = self.size if self.size in sizes else sizes[0]
        self.send(type="want", **self._wants, size=size, policy=None)

    def _start(self, work: Any, name: str) -> None:
        self._tasks.append(asyncio.create_task(work, name=name))

    async def _beat(self) -> None:
        began_s = time.monotonic()
        while self.drive.readyState == "open":
            self.ping()
            is_new = time.monotonic() - began_s < _EAGER_S and len(self._answered) < _EAGER_PONGS
            calm_s = _KEEN_PAUSE_S if self.is_keen else _CALM_PAUSE_S
            await asyncio.sleep(_EAGER_PAUSE_S if is_new else calm_s)

    async def _report(self) -> None:
        # Many clients of one process must not report in the same millisecond.
        await asyncio.sleep(random.uniform(0, INTERVAL_S))
        while self.drive.readyState == "open":
            if self._reporter.is_due(eager=self.is_keen):
                self.drive.send(compact.write(self._measured()))
            await asyncio.sleep(INTERVAL_S)

    def _measured(self) -> messages.Report:
        return self._reporter.report(
            sound=self._received("audio") if self._wants["sound"] else None,
            picture=self._received("video") if self._wants["picture"] else None,
            now_s=time.monotonic(),
            ahead_ms=self.clock.ahead_ms,
            clock_error_ms=self.clock.error_ms,
        )

    def _received(self, kind: Kind) -> ReceivedStream:
        return ReceivedStream(self.media.counts(kind), self.media.newest(kind))

    def _acknowledge(self, kind: Kind, packet: RtpHeader) -> None:
        if self._receipts is not None and self._receipts.ends_unit(kind, packet):
            self._receipt(kind, packet.timestamp)

    def _receipt(self, kind: Kind, rtp: int) -> None:
        if self.state.readyState == "open":
            self.send(type="received", kind=kind, rtp=rtp)

    def _heard(self, data: str | bytes) -> None:
        message: dict[str, Any] = json.loads(data)
        if message["type"] == "room_change":
            message = room_change.applied(self.newest("room"), message)
        self._newest[message["type"]] = message
        self._reporter.handle(message)
        if message["type"] == "hello":
            self._receipts = Receipts() if message["acknowledge"] else None
        elif message["type"] == "units" and self._receipts is not None:
            for rtp in self._receipts.learn(message["last_rtp"], message["length"]):
                self._receipt("audio", rtp)
        if self._on_message is not None:
            self._on_message(message)
        self._news.set()

    def _heard_drive(self, data: str | bytes) -> None:
        now_ms = _now_ms()
        pong = compact.read(data, messages.DRIVE_COLUMNS)
        self.beat = pong.get("beat", self.beat)
        if pong["type"] != "pong":
            return
        self.clock.add(pong["sent_page_ms"], now_ms, pong["server_ms"])
        if self._pong is None or pong["id"] > self._pong[0]:
            self._pong = pong["id"], now_ms
        self._answered.append(pong["id"])
        self._news.set()


def _now_ms() -> float:
    return time.monotonic() * 1000.0
