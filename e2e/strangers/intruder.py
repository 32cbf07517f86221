"""A hostile viewer: libraries shake hands for it, and what it sends then it writes itself."""

from __future__ import annotations

import asyncio
import json
import time
import uuid
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count, pairwise
from typing import TYPE_CHECKING, Any, Final, Self

from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from e2e.strangers import wire

if TYPE_CHECKING:
    from collections.abc import Iterable

_ANSWER_S: Final = 15.0
_OPEN_S: Final = 15.0
_AGAIN_S: Final = 0.3
_TRIES: Final = 60
_BEAT_S: Final = 1.0
_REPORT_S: Final = 0.1


class NoPlaceError(ConnectionError):
    """An address has all the places that it may have; another has others."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a server said to a request; 0 where it closed the connection instead."""

    status: int
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes = b""

    @property
    def cookie(self) -> str | None:
        """The cookie that it gives, as it is shown again."""
        given = self.headers.get("set-cookie")
        return None if given is None else given.partition(";")[0]

    @property
    def is_full(self) -> bool:
        """Whether its address has all the places that it may have."""
        return self.status == 503 and b'"door.full_for_address"' in self.body

    def json(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.body)
        return found


async def ask(
    port: int,
    method: str,
    path: str,
    *,
    source: str = "127.0.0.1",
    body: dict[str, Any] | None = None,
    headers: Iterable[tuple[str, str]] = (),
    within_s: float = _ANSWER_S,
) -> Answer:
    """Ask over a connection of its own from an address of the loopback net."""
    said = b"" if body is None else json.dumps(body).encode()
    request = wire.http(method, path, body=said, headers=[*headers, ("Connection", "close")])
    try:
        async with asyncio.timeout(within_s):
            reader, writer = await asyncio.open_connection(
                "127.0.0.1", port, local_addr=(source, 0)
            )
            try:
                writer.write(request)
                return _parsed(await reader.read(-1))
            finally:
                writer.transport.abort()
    except (OSError, TimeoutError):
        return Answer(0)


def _parsed(data: bytes) -> Answer:
    head, _, body = data.partition(b"\r\n\r\n")
    first, *lines = head.decode("latin-1").split("\r\n")
    words = first.split()
    if len(words) < 2:
        return Answer(0)
    headers = {name.lower(): value.strip() for name, _, value in (x.partition(":") for x in lines)}
    if headers.get("transfer-encoding") == "chunked":
        body = _unchunked(body)
    return Answer(int(words[1]), headers, body)


def _unchunked(data: bytes) -> bytes:
    whole = b""
    while data:
        size, _, data = data.partition(b"\r\n")
        length = int(size or b"0", 16)
        if length == 0:
            break
        whole, data = whole + data[:length], data[length + 2 :]
    return whole


class Intruder:
    """One viewer from `connect` to `close`; it has the channels of a page, and its cookie.

    `counts` are datagrams and bytes of its socket: what was sent, and what came, media and what is
    sent again of them (RFC 4588) apart.
    """

    def __init__(self, port: int, *, source: str = "127.0.0.1", sees: bool = False) -> None:
        self.port = port
        self.source = source
        self.sees = sees
        self.client = str(uuid.uuid4())
        self.cookie: str | None = None
        self.counts: Counter[str] = Counter()
        self.newest: dict[int, int] = {}
        """The newest sequence number of each SSRC."""
        self.told: dict[str, dict[str, Any]] = {}
        """The newest message of each type on the state channel."""
        self.heard = asyncio.Event()
        self._pc = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.state = self._pc.createDataChannel("state")
        self.drive = self._pc.createDataChannel("drive", ordered=False, maxRetransmits=0)
        self._arrived: list[tuple[int, float]] = []
        self._again: set[int] = set()
        self._tasks: list[asyncio.Task[None]] = []
        for kind in ("audio", "video"):
            self._pc.addTransceiver(kind, direction="recvonly")
        self.state.on("message", self._told)

    async def __aenter__(self) -> Self:
        try:
            await self.connect()
        except BaseException:
            await self.close()
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def connect(self) -> None:
        """Come in as a page does; raises `NoPlaceError`, or `ConnectionError` if refused."""
        answer = await self.offer()
        if answer.is_full:
            raise NoPlaceError(self.source)
        if answer.status != 200:
            raise ConnectionError(f"refused: {answer.status} {answer.body[:200]!r}")
        await self._pc.setRemoteDescription(RTCSessionDescription(answer.json()["sdp"], "answer"))
        for protocol in self._ice._protocols:
            protocol.datagram_received = self._tapped(protocol.datagram_received)
            protocol.transport.sendto = self._counted(protocol.transport.sendto)
        if not await self.until("hello", within_s=_OPEN_S):
            raise ConnectionError(f"not open: {self._pc.connectionState}")
        self.say(
            type="want",
            sound=False,
            picture=self.sees,
            size=self.told["hello"]["sizes"][0],
            policy=None,
        )
        self._tasks = [asyncio.create_task(work) for work in (self._beat(), self._report())]

    async def offer(self) -> Answer:
        """Offer until it is let in, as a page does, or its address has no more places."""
        for _ in range(_TRIES):
            answer = await self.knock()
            if answer.status not in (429, 503) or answer.is_full:
                break
            await asyncio.sleep(_AGAIN_S)
        return answer

    async def knock(self) -> Answer:
        """Offer once."""
        answer = await self.post("/api/offer", sdp=await self.description())
        self.cookie = answer.cookie or self.cookie
        return answer

    async def description(self) -> str:
        """Return its offer as a browser writes it."""
        if self._pc.localDescription is None:
            await self._pc.setLocalDescription(await self._pc.createOffer())
            self._again = wire.repeating(self._pc.localDescription.sdp)
        return wire.with_feedback(self._pc.localDescription.sdp)

    async def post(self, path: str, **body: Any) -> Answer:
        """Ask by HTTP as this viewer."""
        headers = [] if self.cookie is None else [("Cookie", self.cookie)]
        return await ask(
            self.port,
            "POST",
            path,
            source=self.source,
            body={"client": self.client, **body},
            headers=headers,
        )

    async def close(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._pc.close()

    # --- what it sends --------------------------------------------------------------------

    async def send_rtcp(self, packets: bytes) -> None:
        """Send RTCP, protected as the two ends have agreed."""
        with suppress(ConnectionError):
            await self._dtls._send_rtp(packets)

    async def send_sctp(self, chunks: bytes) -> None:
        """Send chunks inside the association, in one datagram."""
        with suppress(ConnectionError):
            await self._dtls._send_data(wire.sctp(self._sctp._remote_verification_tag, chunks))

    def send_raw(self, datagram: bytes) -> None:
        """Send from its verified address whatever there is to send."""
        pair = self._ice._nominated.get(1)
        if pair is not None and pair.protocol.transport is not None:
            pair.protocol.transport.sendto(datagram, pair.remote_addr)

    def say(self, **message: Any) -> None:
        """Say something on the state channel, if that is open."""
        if self.state.readyState == "open":
            self.state.send(json.dumps(message))

    async def until(self, kind: str, *, within_s: float = 5.0) -> bool:
        """Wait for a message of a type."""
        with suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                while kind not in self.told:
                    self.heard.clear()
                    await self.heard.wait()
        return kind in self.told

    @property
    def media_address(self) -> tuple[str, int]:
        """Where this viewer sends to: the port that everybody shares."""
        host, port = self._ice._nominated[1].remote_addr
        return str(host), int(port)

    @property
    def is_connected(self) -> bool:
        return bool(self._pc.connectionState == "connected")

    # --- inside ---------------------------------------------------------------------------

    @property
    def _sctp(self) -> Any:
        return self._pc.sctp

    @property
    def _dtls(self) -> Any:
        return self._sctp.transport

    @property
    def _ice(self) -> Any:
        return self._dtls.transport._connection

    def _tapped(self, onwards: Any) -> Any:
        def received(datagram: bytes, address: Any) -> None:
            numbers = wire.media_numbers(datagram)
            kind = "other" if numbers is None else "media"
            if numbers is not None and datagram[1] & 0x7F in self._again:
                kind = "again"
            self.counts[kind] += 1
            self.counts[f"{kind} bytes"] += len(datagram)
            if numbers is None:
                onwards(datagram, address)  # ICE and DTLS go on: it wants to stay
                return
            ssrc, self.newest[ssrc], transport = numbers
            if transport is not None:
                self._arrived.append((transport, time.monotonic()))

        return received

    def _counted(self, onwards: Any) -> Any:
        def sent(datagram: bytes, address: Any) -> None:
            self.counts["sent"] += 1
            self.counts["sent bytes"] += len(datagram)
            onwards(datagram, address)

        return sent

    def _told(self, text: str) -> None:
        message = json.loads(text)
        self.told[message["type"]] = message
        self.heard.set()

    async def _beat(self) -> None:
        for number in count(1):
            row = ["ping", number, time.monotonic() * 1000, None, None]
            if self.drive.readyState == "open":
                self.drive.send(json.dumps(row))
            await asyncio.sleep(_BEAT_S)

    async def _report(self) -> None:
        """Praise the link, so that there is something to be drawn from it."""
        for number in count():
            await asyncio.sleep(_REPORT_S)
            came, self._arrived = self._arrived, []
            gap = (at for at, (a, b) in enumerate(pairwise(came), 1) if b[0] != (a[0] + 1) % 2**16)
            if came:
                await self.send_rtcp(wire.announces_arrived(came[: next(gap, None)], number))
