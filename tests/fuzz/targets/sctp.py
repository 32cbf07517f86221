"""An admitted page's SCTP chunks, as aiortc and our bounds handle one packet of them."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any, Final, cast

from aiortc import RTCSctpTransport
from aiortc.rtcsctptransport import (
    AbortChunk,
    Chunk,
    CookieEchoChunk,
    DataChunk,
    ForwardTsnChunk,
    HeartbeatChunk,
    InitChunk,
    ReconfigChunk,
    SackChunk,
    ShutdownChunk,
    serialize_packet,
)
from tests.fuzz.target import Target

from wax.rtc import private, private_association

_TAG: Final = 7
_TSN: Final = 1000
_HEADER_BYTES: Final = 12


class _Transport:
    """A DTLS transport without a connection."""

    state = "connected"

    async def _send_data(self, data: bytes) -> None: ...


class _Chunks(Chunk):
    """Bytes in place of chunks, with a right header and checksum."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def __bytes__(self) -> bytes:
        return self._data


async def _hear_one(data: bytes) -> None:
    sctp = RTCSctpTransport(cast("Any", _Transport()))
    sctp._association_state = RTCSctpTransport.State.ESTABLISHED
    sctp._local_verification_tag = sctp._remote_verification_tag = _TAG
    sctp._remote_port, sctp._last_received_tsn, sctp._inbound_streams_count = 5000, _TSN, 100
    association = private_association.bound_association(sctp, lambda _why: None)
    private_association.delay_acknowledgements(sctp, association.acknowledgement, 0.1)
    # The transport ends a peer whose packet raises anything.
    with contextlib.suppress(Exception):
        await sctp._handle_data(serialize_packet(5000, 5000, _TAG, _Chunks(data)))


def _hear(data: bytes) -> None:
    private.install()
    loop = asyncio.new_event_loop()
    try:
        loop.run_until_complete(_hear_one(data))
    finally:
        for task in asyncio.all_tasks(loop):  # what it began to send
            task.cancel()
        loop.close()


def _data(text: bytes, *, ahead: int = 1, flags: int = 3) -> DataChunk:
    chunk = DataChunk(flags=flags)
    chunk.tsn, chunk.stream_id, chunk.stream_seq = _TSN + ahead, 1, 0
    chunk.protocol, chunk.user_data = 51, text
    return chunk


def _sack(*gaps: tuple[int, int]) -> SackChunk:
    chunk = SackChunk()
    chunk.cumulative_tsn, chunk.advertised_rwnd, chunk.gaps = 1, 100_000, list(gaps)
    return chunk


def _skip() -> ForwardTsnChunk:
    chunk = ForwardTsnChunk()
    chunk.cumulative_tsn, chunk.streams = _TSN + 3, [(1, 2)]
    return chunk


def _init() -> InitChunk:
    chunk = InitChunk()
    chunk.initiate_tag, chunk.advertised_rwnd, chunk.initial_tsn = _TAG, 100_000, _TSN
    chunk.outbound_streams = chunk.inbound_streams = 10
    return chunk


SCTP: Final = Target(
    name="sctp",
    what="chunks of an admitted page's SCTP",
    hear=_hear,
    seeds=tuple(
        b"".join(map(bytes, chunks))
        for chunks in (
            (_data(b"hello"),),
            (_data(b"a", flags=2), _data(b"b", ahead=2, flags=1), _sack()),
            (_data(b"x", ahead=5), _skip(), _sack((2, 3))),
            (HeartbeatChunk(),),
            (_init(),),
            (CookieEchoChunk(body=bytes(24)),),
            (ReconfigChunk(),),
            (ShutdownChunk(),),
            (AbortChunk(),),
        )
    ),
    words=(
        *(bytes((kind, 0, 0, 4)) for kind in (4, 6, 7, 8, 11, 14, 130, 192)),
        *(b"\x00\x03\x00\x14", b"\x03\x00\x00\x10", b"\x00\x0d\x00\x10", b"\x00\x01\x00\x04"),
    ),
    max_bytes=1200 - _HEADER_BYTES,
)
