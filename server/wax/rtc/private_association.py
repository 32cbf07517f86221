"""All uses of private parts of aiortc's SCTP: bounds of an association, and its acknowledgements.

`wax.rtc.private.check` verifies that these parts exist.
"""

from __future__ import annotations

import asyncio
import struct
from bisect import insort
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, cast

from aiortc import rtcsctptransport
from OpenSSL import SSL

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from aiortc import RTCSctpTransport

_BURST: Final = 4
_BURST_S: Final = 0.05
"""This many packets within this time belong to one message, whose sender may be waiting for the
acknowledgement. Set-points are further apart."""
MAX_WAITING_BYTES: Final = 65_536
_MAX_FRAGMENTS: Final = 64
"""Fragments of incomplete messages: those of the longest message, 64 KiB, and a few more."""
_MAX_AHEAD: Final = 256
"""Chunks beyond a missing one: as many gaps as fit into an acknowledgement in one datagram."""
_MAX_STREAMS: Final = 8
"""A page has two data channels."""
_MAX_CHUNKS: Final = 32
"""Per packet: a message of the page fills a tenth of one. Further chunks count as lost."""
_MAX_INITS: Final = 8
"""Before there is an association: the number of attempts (RFC 9260, Max.Init.Retransmits)."""
_ANSWERED: Final = frozenset((1, 2, 4, 7, 10, 130))
"""INIT, INIT ACK, HEARTBEAT, SHUTDOWN, COOKIE ECHO and RE-CONFIG get an answer at once."""
_REPEATED: Final = frozenset((0,))
"""Only DATA comes more than once in a packet."""
_RECONFIG_BYTES: Final = {13: 12 + 2 * _MAX_STREAMS, 16: 16}
"""Lengths without header of the parameters that browsers send (RFC 6525, 4.1 and 4.4): a request
that resets streams, and a response to ours."""
_SACK_BYTES: Final = 28
"""A packet with a SACK that has neither gaps nor duplicates."""
_WHOLE: Final = 0b11
"""The flags of a chunk that begins a message and ends it (RFC 9260, 3.3.1)."""
_MAX_CHUNKS_BYTES: Final = (
    rtcsctptransport.SCTP_MAX_PACKET_LENGTH - rtcsctptransport.SCTP_COMMON_HEADER_LENGTH
)
_UINT32: Final = 2**32


def delay_acknowledgements(
    sctp: RTCSctpTransport,
    acknowledgement: Callable[[], rtcsctptransport.SackChunk | None],
    delay_s: float,
) -> None:
    """Acknowledge everything within `delay_s` together (RFC 9260, 6.2; at most 200 ms).

    aiortc acknowledges each message at once, in a datagram of 93 bytes: at twenty set-points a
    second, a third of a modem's rate. A waiting acknowledgement leaves with data if any is sent
    sooner. Messages of many packets are acknowledged immediately.
    """
    delayed = _DelayedAcknowledgements(sctp, acknowledgement, delay_s)
    sctp._send_sack = delayed.send_later  # type: ignore[method-assign]
    sctp._send_chunk = delayed.send  # type: ignore[method-assign]


class _DelayedAcknowledgements:
    def __init__(
        self,
        sctp: RTCSctpTransport,
        acknowledgement: Callable[[], rtcsctptransport.SackChunk | None],
        delay_s: float,
    ) -> None:
        self._sctp = sctp
        self._acknowledgement = acknowledgement
        self._delay_s = delay_s
        self._send_chunk = sctp._send_chunk
        self._waiting: asyncio.TimerHandle | None = None
        self._under_way: set[asyncio.Task[Any]] = set()
        self._came_s: deque[float] = deque(maxlen=_BURST)

    async def send_later(self) -> None:
        loop = asyncio.get_running_loop()
        self._came_s.append(loop.time())
        if len(self._came_s) == _BURST and self._came_s[-1] - self._came_s[0] < _BURST_S:
            await self._send_now()
        elif self._waiting is None:
            self._waiting = loop.call_later(self._delay_s, self._due)

    async def send(self, chunk: rtcsctptransport.Chunk) -> None:
        """Send a chunk, bundling DATA with a waiting acknowledgement (RFC 9260, 6.10)."""
        is_data = isinstance(chunk, rtcsctptransport.DataChunk)
        sack = self._acknowledgement() if is_data and self._stop_waiting() else None
        if sack is None:
            await self._send_alone(chunk)
            return
        both = _Bundle((sack, chunk))
        if len(bytes(both)) <= _MAX_CHUNKS_BYTES:
            await self._send_alone(cast("Any", both))
        else:
            await self._send_alone(sack)
            await self._send_alone(chunk)

    async def _send_alone(self, chunk: rtcsctptransport.Chunk) -> None:
        """Send one packet, which counts as lost if DTLS has closed or is closing.

        aiortc sends in tasks that nobody awaits: an error there would only fill the log.
        """
        try:
            await self._send_chunk(chunk)
        except (ConnectionError, SSL.Error):
            if self._sctp.state == "closed":
                # Nothing will be acknowledged any more; aiortc would retransmit for ever.
                for name in ("_t3_start", "_t3_restart"):
                    setattr(self._sctp, name, _do_nothing)

    def _stop_waiting(self) -> bool:
        """Cancel a waiting acknowledgement; return whether there was one."""
        self._came_s.clear()
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting.cancel()
        return waiting is not None

    async def _send_now(self) -> None:
        # Data may have carried it. While DTLS closes, it refuses data with an error of its own.
        if not self._stop_waiting() or self._sctp.state == "closed":
            return
        if (sack := self._acknowledgement()) is not None:
            await self._sctp._send_chunk(sack)

    def _due(self) -> None:
        task = asyncio.ensure_future(self._send_now())
        self._under_way.add(task)
        task.add_done_callback(self._under_way.discard)


def _do_nothing() -> None:
    pass


@dataclass(frozen=True, slots=True)
class _Bundle:
    """Several chunks of one packet, which aiortc writes like a single one."""

    chunks: tuple[rtcsctptransport.Chunk, ...]

    def __bytes__(self) -> bytes:
        return b"".join(map(bytes, self.chunks))


def bound_association(sctp: RTCSctpTransport, on_excess: Callable[[str], None]) -> Association:
    """Bound what a page can make aiortc store, search and answer.

    `on_excess` gets the reason, once. aiortc keeps fragments without bound and searches all of them
    for each new one. Beyond the bounds the page's data is ignored. Chunks far ahead of a missing
    one are not accepted yet, as a receiver without buffer space may do (RFC 9260, 6.2).
    """
    association = Association(sctp)
    is_over = False

    async def heard(data: bytes) -> None:
        nonlocal is_over
        if is_over:
            return
        try:
            why = await association.handle_packet(data)
        except ConnectionError:
            raise
        except Exception as error:
            # The page has the keys, so it has caused whatever error aiortc raises.
            why = f"it sent what is not understood ({error!r})"
        if why is not None:
            is_over = True
            on_excess(why)

    for name, method in (("_handle_data", heard), ("_mark_received", association.mark_received)):
        setattr(sctp, name, method)
    return association


class Association:
    """Handles a browser's packets, and answers with no more bytes than came in.

    Of each packet it handles DATA, one SACK, and one chunk that demands an answer: a browser sends
    one HEARTBEAT, RE-CONFIG or COOKIE ECHO at a time.
    """

    def __init__(self, sctp: RTCSctpTransport) -> None:
        self._sctp = sctp
        self._inits = 0
        self._unanswered_bytes = 0

    async def handle_packet(self, data: bytes) -> str | None:
        """Handle a packet; return which bound it exceeds, None if none.

        A packet that cannot be parsed is ignored, as RFC 9260 requires.
        """
        sctp = self._sctp
        found = _chunks(data)
        is_init = bool(found) and found[0][0] == rtcsctptransport.InitChunk.type
        tag = 0 if is_init else sctp._local_verification_tag
        if sctp.state == "closed" or data[4:8] != tag.to_bytes(4):
            return None
        taken: set[int] = set()
        for kind, flags, body in found[:1] if is_init else found:
            group = _ANSWERED if kind in _ANSWERED else frozenset((kind,))
            if kind not in _REPEATED and not taken.isdisjoint(group):
                continue
            taken.add(kind)
            try:
                chunk = rtcsctptransport.CHUNK_TYPES[kind](flags, body)
            except (ValueError, struct.error):
                return None
            if (why := await self._handle_chunk(chunk)) is not None:
                return why
        self._unanswered_bytes += len(data)
        why = _excess(sctp)
        if why is None and sctp._sack_needed:
            await sctp._send_sack()
        return why

    async def _handle_chunk(self, chunk: rtcsctptransport.Chunk) -> str | None:
        why = self._refusal(chunk)
        if why is None and not self._ignores(chunk):
            await self._sctp._receive_chunk(chunk)
            why = _too_many_streams(self._sctp)
        return why

    def _refusal(self, chunk: rtcsctptransport.Chunk) -> str | None:
        if isinstance(chunk, rtcsctptransport.SackChunk):
            is_wrong = _acknowledges_unsent(self._sctp, chunk)
            return "it acknowledges what was not sent" if is_wrong else None
        if isinstance(chunk, rtcsctptransport.ForwardTsnChunk):
            is_wrong = len(chunk.streams) > _MAX_STREAMS
        elif isinstance(chunk, rtcsctptransport.ReconfigChunk):
            first = dict(reversed(chunk.params))
            chunk.params = [(kind, first[kind]) for kind in _RECONFIG_BYTES if kind in first]
            is_wrong = any(len(value) > _RECONFIG_BYTES[kind] for kind, value in chunk.params)
        else:
            return None
        return f"it names more than {_MAX_STREAMS} streams" if is_wrong else None

    def _ignores(self, chunk: rtcsctptransport.Chunk) -> bool:
        sctp = self._sctp
        if isinstance(chunk, rtcsctptransport.DataChunk):
            is_too_far = _is_too_far_ahead(sctp, chunk)
            sctp._sack_needed = sctp._sack_needed or is_too_far
            return is_too_far
        if isinstance(chunk, rtcsctptransport.InitChunk):
            self._inits += 1  # no browser restarts it with the same keys
            return sctp.state == "connected" or self._inits > _MAX_INITS
        if isinstance(chunk, rtcsctptransport.ShutdownChunk):
            # Close without an answer; aiortc would send it ten times.
            sctp._set_state(sctp.State.CLOSED)
            return True
        return False

    def mark_received(self, tsn: int) -> bool:
        """Record a TSN; return whether it is known. aiortc sorts all waiting ones every time."""
        sctp = self._sctp
        newest, ahead = sctp._last_received_tsn, sctp._sack_misordered
        if newest is None or (tsn - newest - 1) % _UINT32 >= _UINT32 // 2 or tsn in ahead:
            if len(sctp._sack_duplicates) < _MAX_AHEAD:
                sctp._sack_duplicates.append(tsn)
            return True
        ahead.add(tsn)
        while (following := (newest + 1) % _UINT32) in ahead:
            ahead.remove(following)
            newest = following
        sctp._last_received_tsn = newest
        return False

    def acknowledgement(self) -> rtcsctptransport.SackChunk | None:
        """Return a SACK with gaps and duplicates, but no longer than what came in.

        The other end retransmits the TSNs that are left out (RFC 9260, 6.2: as many as fit).
        """
        sctp = self._sctp
        newest = sctp._last_received_tsn
        if newest is None:
            return None
        room = max(self._unanswered_bytes - _SACK_BYTES, 0) // 4
        sack = rtcsctptransport.SackChunk()
        sack.cumulative_tsn = newest
        sack.advertised_rwnd = max(0, sctp._advertised_rwnd)
        sack.gaps = _gaps(sctp._sack_misordered, newest)[: min(room, _MAX_AHEAD)]
        sack.duplicates = sctp._sack_duplicates[: min(room, _MAX_AHEAD) - len(sack.gaps)]
        sctp._sack_duplicates.clear()
        sctp._sack_needed = False
        self._unanswered_bytes = 0
        return sack


_crc32c: Any = cast("Any", rtcsctptransport).crc32c


def _chunks(packet: bytes) -> list[tuple[int, int, bytes]]:
    """Return type, flags and body of the first chunks that aiortc knows; none of a broken packet.

    aiortc would make objects of all chunks.
    """
    found: list[tuple[int, int, bytes]] = []
    at = rtcsctptransport.SCTP_COMMON_HEADER_LENGTH
    if len(packet) < at + 4 or int.from_bytes(packet[8:12], "little") != _crc32c(
        packet[:8] + bytes(4) + packet[12:]
    ):
        return []
    while at + 4 <= len(packet) and len(found) < _MAX_CHUNKS:
        length = int.from_bytes(packet[at + 2 : at + 4])
        if length < 4 or at + length > len(packet):
            return []
        if packet[at] in rtcsctptransport.CHUNK_TYPES:
            found.append((packet[at], packet[at + 1], packet[at + 4 : at + length]))
        at += length + -length % 4
    return found


def _gaps(ahead: Collection[int], newest: int) -> list[tuple[int, int]]:
    """Return the runs of received TSNs, in order, as offsets from the newest acknowledged."""
    gaps: list[tuple[int, int]] = []
    for place in sorted([(tsn - newest) % _UINT32 for tsn in ahead]):
        if gaps and place == gaps[-1][1] + 1:
            gaps[-1] = gaps[-1][0], place
        else:
            gaps.append((place, place))
    return gaps


def add_chunk(stream: rtcsctptransport.InboundStream, chunk: rtcsctptransport.DataChunk) -> None:
    """Insert a chunk in TSN order by bisection; aiortc searches one by one."""
    before = chunk.tsn - _UINT32 // 2
    insort(stream.reassembly, chunk, key=lambda one: (one.tsn - before) % _UINT32)


def _is_too_far_ahead(sctp: RTCSctpTransport, chunk: rtcsctptransport.DataChunk) -> bool:
    newest: int | None = sctp._last_received_tsn
    if len(sctp._sack_misordered) < _MAX_AHEAD or newest is None:
        return False
    tsn: int = chunk.tsn
    return tsn != (newest + 1) % _UINT32


def _acknowledges_unsent(sctp: RTCSctpTransport, sack: rtcsctptransport.SackChunk) -> bool:
    """Whether the SACK covers more than is in flight: aiortc loops over every TSN in a gap."""
    under_way: int = (sctp._local_tsn - 1 - sack.cumulative_tsn) % _UINT32
    told: int = sum(max(end - begin + 1, 0) for begin, end in sack.gaps)
    return under_way >= _UINT32 // 2 or told > under_way


def _too_many_streams(sctp: RTCSctpTransport) -> str | None:
    if max(len(sctp._inbound_streams), len(sctp._data_channels)) > _MAX_STREAMS:
        return f"it has more than {_MAX_STREAMS} streams"
    return None


def _excess(sctp: RTCSctpTransport) -> str | None:
    """Return which bound is exceeded, None if none is."""
    waiting = [chunk for stream in sctp._inbound_streams.values() for chunk in stream.reassembly]
    if sum(chunk.flags & _WHOLE != _WHOLE for chunk in waiting) > _MAX_FRAGMENTS:
        return f"more than {_MAX_FRAGMENTS} fragments of messages wait for the rest"
    if sum(len(chunk.user_data) for chunk in waiting) > MAX_WAITING_BYTES:
        return f"more than {MAX_WAITING_BYTES} bytes wait for what is missing"
    if len(waiting) > _MAX_AHEAD + _MAX_FRAGMENTS:
        return "too many messages wait for what is missing"
    return None
