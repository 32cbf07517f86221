"""A hostile viewer: our own client joins and stays, and attacks with the methods here."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from yarl import URL

from e2e.strangers import wire
from wax.client import Client, rtp_header
from wax.client.sdp import agreed, as_browser

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aiortc import RTCCertificate

_ANSWER_S: Final = 15.0
_AGAIN_S: Final = 0.3
_TRIES: Final = 60


class NoPlaceError(ConnectionError):
    """An address has used up its places, or the server is full."""


@dataclass(frozen=True, slots=True)
class Answer:
    """A server's answer to a request; status 0 if it closed the connection instead."""

    status: int
    body: bytes = b""

    @property
    def is_full(self) -> bool:
        codes = b'"door.full_for_address"', b'"door.machine_full"'
        return self.status == 503 and any(code in self.body for code in codes)


async def ask(
    port: int,
    method: str,
    path: str,
    *,
    source: str = "127.0.0.1",
    body: Mapping[str, Any] | None = None,
    cookies: aiohttp.CookieJar | None = None,
    within_s: float = _ANSWER_S,
) -> Answer:
    """Send a request over a new connection from a loopback address."""
    connector = aiohttp.TCPConnector(local_addr=(source, 0), force_close=True)
    patience = aiohttp.ClientTimeout(within_s)
    try:
        async with (
            aiohttp.ClientSession(
                connector=connector, timeout=patience, cookie_jar=cookies
            ) as http,
            http.request(method, f"http://127.0.0.1:{port}{path}", json=body) as said,
        ):
            return Answer(said.status, await said.read())
    except (aiohttp.ClientError, OSError, TimeoutError):
        return Answer(0)


class Intruder(Client):
    """`counts` are datagrams and bytes of its socket, by kind.

    The kinds are: sent, received media, retransmitted media (RFC 4588), and the rest.
    """

    def __init__(self, port: int, *, source: str = "127.0.0.1", sees: bool = False) -> None:
        url = f"http://127.0.0.1:{port}"
        super().__init__(url, sound=False, picture=sees, on_socket=self._tap)
        self.port = port
        self.source = source
        self.counts: Counter[str] = Counter()
        self.sequence_numbers: dict[int, int] = {}
        """The newest RTP sequence number of each SSRC."""
        self._again: frozenset[int] = frozenset()

    async def description(self) -> str:
        """Return its offer as a browser writes it."""
        if self.peer.localDescription is None:
            await self.peer.setLocalDescription(await self.peer.createOffer())
        return as_browser(self.peer.localDescription.sdp)

    async def send_rtcp(self, packets: bytes) -> None:
        """Send RTCP, encrypted with the session's keys."""
        with suppress(ConnectionError):
            await self._dtls._send_rtp(packets)

    async def send_sctp(self, chunks: bytes) -> None:
        """Send chunks inside the association, in one datagram."""
        association: Any = self.peer.sctp
        with suppress(ConnectionError):
            await self._dtls._send_data(wire.sctp(association._remote_verification_tag, chunks))

    @property
    def cookie(self) -> str:
        """The header by which the server recognises it."""
        shown = self.cookies.filter_cookies(URL(f"http://127.0.0.1:{self.port}"))
        return "Cookie: " + "; ".join(f"{name}={one.value}" for name, one in shown.items())

    @property
    def media_address(self) -> tuple[str, int]:
        """The address that this viewer sends to: the port that all share."""
        host, port = self.pair.remote_addr
        return str(host), int(port)

    @property
    def pair(self) -> Any:
        """The nominated pair; raises `ConnectionError` once the server has closed its peer."""
        found = self.ice._nominated.get(1)
        if found is None:
            raise ConnectionError("this viewer has no path to the server")
        return found

    @property
    def ice(self) -> Any:
        """The ICE connection of aioice."""
        return self._dtls.transport._connection

    def show(self, certificate: RTCCertificate) -> None:
        """Show another certificate than its own; before `connect`."""
        transports: set[Any] = {one.receiver.transport for one in self.peer.getTransceivers()}
        for dtls in transports | {self._dtls}:
            dtls._RTCDtlsTransport__local_certificate = certificate

    @property
    def is_connected(self) -> bool:
        return bool(self.peer.connectionState == "connected")

    @property
    def _dtls(self) -> Any:
        association: Any = self.peer.sctp
        return association.transport

    async def _exchange(self, offer: str) -> str:
        """Offer until it is admitted; raises `NoPlaceError`, or `ConnectionError` if refused."""
        for _ in range(_TRIES):
            sent = {"sdp": await self.description(), "client": self.client_id}
            answer = await ask(
                self.port,
                "POST",
                "/api/offer",
                source=self.source,
                body=sent,
                cookies=self.cookies,
            )
            if answer.is_full:
                raise NoPlaceError(self.source)
            if answer.status not in (429, 503):
                break
            await asyncio.sleep(_AGAIN_S)
        if answer.status != 200:
            raise ConnectionError(f"refused: {answer.status} {answer.body[:200]!r}")
        sdp = str(json.loads(answer.body)["sdp"])
        self._again = agreed(sdp).retransmissions
        return sdp

    def _tap(self, protocol: Any) -> None:
        """Count the datagrams of one socket; ICE, DTLS and media go on, so that it stays."""
        came, sends = protocol.datagram_received, protocol.transport.sendto

        def received(datagram: bytes, address: Any) -> None:
            packet = rtp_header.read(datagram, None) if rtp_header.is_rtp(datagram) else None
            kind = "other"
            if packet is not None:
                kind = "again" if packet.payload_type in self._again else "media"
                self.sequence_numbers[packet.ssrc] = packet.sequence_number
            self._count(kind, datagram)
            came(datagram, address)

        def sent(datagram: bytes, address: Any) -> None:
            if not protocol.transport.is_closing():  # as another attack of the same viewer has it
                self._count("sent", datagram)
                sends(datagram, address)

        protocol.datagram_received, protocol.transport.sendto = received, sent

    def _count(self, kind: str, datagram: bytes) -> None:
        self.counts[kind] += 1
        self.counts[f"{kind} bytes"] += len(datagram)
