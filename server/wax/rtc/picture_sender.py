"""The picture to one browser: the best one when the link is free, and lost packets again."""

from __future__ import annotations

import asyncio
import random
from collections import deque
from typing import TYPE_CHECKING, Final, Literal

from aiortc.rtp import RtcpPsfbPacket, RtcpRtpfbPacket

from wax.congestion.pacer import gap_s
from wax.rtc import rtp
from wax.rtc.payload import h264
from wax.rtc.payload.vp8 import Vp8Packetizer
from wax.rtc.retransmissions import Retransmissions
from wax.rtc.sender import UINT16, UINT32, Sender, SenderContext
from wax.rtc.sent_history import SentHistory, SentPacket

if TYPE_CHECKING:
    from collections.abc import Callable

    from aiortc.rtp import AnyRtcpPacket

    from wax.rtc.lane import Picture, PictureLane

_TICK_S: Final = 0.001
"""An event loop's timer resolution."""
ASK_AGAIN_S: Final = 0.05
"""A wait is asked about again after this, for feedback may have shortened it: libwebrtc sends one
at most this often (RemoteEstimatorProxy)."""
_NOT_AT_ONCE_10MS: Final = 51
"""Just above the 500 ms below which libwebrtc shows pictures at once if the least is 0."""
_NACK: Final = 1
_PLI: Final = 1
_FIR: Final = 4


class PictureSender(Sender):
    """Sends the best picture when the link is free, and lost packets again."""

    kind = "video"
    _extra_name = "rtx"

    def __init__(
        self,
        context: SenderContext,
        *,
        lane: PictureLane,
        codec: Literal["vp8", "h264"],
        round_trip_s: Callable[[], float | None],
        on_keyframe_wanted: Callable[[], None],
    ) -> None:
        super().__init__(context)
        self._lane = lane
        self._packetizer = _packetizer(codec)
        self._round_trip_s = round_trip_s
        self._on_keyframe_wanted = on_keyframe_wanted
        self.shows_at_once = True
        """The browser tells of pictures that it shows at once as of others; Firefox does not."""
        self._playout_delay: rtp.PlayoutDelay | None = None
        self._news = asyncio.Event()
        self._history = SentHistory()
        self._repeats = Retransmissions()
        self._asked_for: deque[int] = deque(maxlen=256)
        self._rtx_number = random.getrandbits(15)
        lane.listen(self._news.set)

    def hold_back(self, least_ms: float) -> bool:
        """Hold pictures back this long in the browser; False if it does not support that."""
        # Zero for both makes Chromium show a picture at once (its low-latency renderer). Equal
        # values, since within a range it would choose.
        steps = min(max(round(least_ms / 10), 0), 4095)
        is_at_once = steps == 0 and not self.shows_at_once
        self._playout_delay = rtp.PlayoutDelay(steps, _NOT_AT_ONCE_10MS if is_at_once else steps)
        return self._ids.playout_delay is not None

    def _asked(self, packet: AnyRtcpPacket) -> None:
        if isinstance(packet, RtcpRtpfbPacket) and packet.fmt == _NACK:
            self._asked_for.extend(packet.lost)
            self._news.set()
        elif isinstance(packet, RtcpPsfbPacket) and packet.fmt in (_PLI, _FIR):
            self._on_keyframe_wanted()

    async def _run_lane(self) -> None:
        while True:
            if (wait_s := self._tap.free_in_s(self._now_s())) > _TICK_S:
                await asyncio.sleep(min(wait_s, ASK_AGAIN_S))
            elif self._asked_for:
                await self._repeat(self._asked_for.popleft())
            elif (picture := self._lane.take()) is not None:
                await self._send_picture(picture)
            else:
                self._news.clear()
                await self._news.wait()

    async def _send_picture(self, picture: Picture) -> None:
        data, pts = picture.data, picture.pts
        now_s = self._now_s()
        train = self._tap.congestion.plan_train(len(data), now_s)
        payloads = self._packetizer(picture, data, train.payload_bytes)
        timestamp = (self.origin + pts) % UINT32
        due_s = now_s
        for index, payload in enumerate(payloads):
            if due_s - self._now_s() > _TICK_S:
                await asyncio.sleep(due_s - self._now_s())
            last = index == len(payloads) - 1
            packet = SentPacket(timestamp, last, payload, self._now_s())
            number, size = await self._send_new(
                self._payload_type,
                packet,
                train=train.number,
                playout_delay=self._playout_delay if index == 0 else None,
            )
            self._history.add(number, packet)
            due_s += gap_s(size, train.pace_bps)
        self._left(picture, pts)

    async def _repeat(self, number: int) -> None:
        now_s = self._now_s()
        lost = self._history.get(number)
        if lost is None or not self._repeats.is_due(number, self._round_trip_s(), now_s):
            return
        if not self._tap.congestion.may_retransmit(len(lost.payload), now_s - lost.sent_s, now_s):
            return
        self._repeats.sent(number, now_s)
        if self._extra_payload_type is None:
            payload_type, to_send, ssrc, sequence_number = (
                self._payload_type,
                lost,
                self.ssrc,
                number,
            )
        else:  # RFC 4588: the number that it first had stands before the payload
            payload_type, ssrc, sequence_number = (
                self._extra_payload_type,
                self.rtx_ssrc,
                self._rtx_number,
            )
            self._rtx_number = (self._rtx_number + 1) % UINT16
            to_send = lost._replace(payload=number.to_bytes(2, "big") + lost.payload)
        await self._send(
            payload_type=payload_type,
            sequence_number=sequence_number,
            ssrc=ssrc,
            packet=to_send,
            repeat=True,
        )


def _packetizer(codec: Literal["vp8", "h264"]) -> Callable[[Picture, bytes, int], list[bytes]]:
    if codec == "h264":
        return lambda _picture, data, max_bytes: h264.packets(data, max_bytes=max_bytes)
    vp8 = Vp8Packetizer(picture_id=random.getrandbits(15), tl0_picidx=random.getrandbits(8))
    return lambda picture, data, max_bytes: vp8.packets(
        data,
        layer=picture.layer,
        sync=picture.sync,
        droppable=picture.droppable,
        keyframe=picture.keyframe,
        max_bytes=max_bytes,
    )
