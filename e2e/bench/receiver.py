"""Receive without decoding: the one place that touches private parts of aiortc, on this side only.

A browser's decoder does not run on the server's machine, so it must not run here either: a
receiver's packet handler is exchanged for one that counts. The counts stand where aiortc keeps
its own statistics, so receiver reports go out as always and the server has the same work.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from aiortc.rtcrtpreceiver import RTCRtpReceiver, StreamStatistics

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from aiortc.rtp import RtpPacket

_STREAMS = "_RTCRtpReceiver__remote_streams"
_HANDLER = "_handle_rtp_packet"
_CLOCK_RATE_HZ = {"audio": 48_000, "video": 90_000}


class CountedStream(StreamStatistics):
    """One SSRC: `packets_received`, `packets_expected` (RFC 3550, A.3), `octets`, `frames`."""

    def __init__(self, clock_rate_hz: int) -> None:
        super().__init__(clock_rate_hz)
        self.octets = 0
        self.frames = 0
        self._frame_time: int | None = None

    def add(self, packet: RtpPacket) -> None:
        super().add(packet)
        self.octets += len(packet.payload)
        if packet.timestamp != self._frame_time:
            self._frame_time = packet.timestamp
            self.frames += 1


def count_only(
    receiver: RTCRtpReceiver,
    kind: Literal["audio", "video"],
    arrived: asyncio.Event,
    came: Callable[[RtpPacket], None],
) -> dict[int, CountedStream]:
    """Make a receiver count instead of decode; returns its streams by SSRC, filled as they come.

    Call it before the connection is made; `arrived` is set with the first packet, `came` is told
    of each. Raises `MeasureError` if aiortc has changed inside.
    """
    streams: dict[int, Any] | None = getattr(receiver, _STREAMS, None)
    if streams is None or not hasattr(receiver, _HANDLER):
        raise MeasureError("this aiortc is built differently inside; mend e2e/bench/receiver.py")
    clock_rate_hz = _CLOCK_RATE_HZ[kind]

    async def count(packet: RtpPacket, arrival_time_ms: int) -> None:
        stream = streams.get(packet.ssrc)
        if stream is None:
            stream = streams[packet.ssrc] = CountedStream(clock_rate_hz)
            arrived.set()
        stream.add(packet)
        came(packet)

    setattr(receiver, _HANDLER, count)
    return streams
