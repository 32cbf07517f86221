"""Pictures to one browser: the best one when the link is free, and retransmissions."""

from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from wax.congestion.pacer import gap_s
from wax.rtc import rtp
from wax.rtc.payload import h264
from wax.rtc.payload.vp8 import Vp8Packetizer
from wax.rtc.retransmission_buffer import RetransmissionBuffer
from wax.rtc.retransmissions import Retransmissions
from wax.rtc.sender import UINT16, UINT32, Sender, SenderContext, wire_bytes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.congestion.control import Train
    from wax.rtc.lane import LanePicture, PictureLane
    from wax.rtc.payload.split import Payload

TICK_S: Final = 0.001
"""An event loop's timer resolution."""
ASK_AGAIN_S: Final = 0.05
"""How soon to ask the pacer again, since feedback may have shortened the wait: libwebrtc sends it
at most this often (RemoteEstimatorProxy)."""
_NOT_AT_ONCE_10MS: Final = 51
"""Just above 500 ms: up to that maximum libwebrtc shows pictures at once if the minimum is 0."""
_MOST_TOGETHER: Final = 16
"""Packets of one picture in a pass of the event loop, which take half a millisecond: a keyframe has
fifty, and leaves to several viewers in the same step."""
_MOST_WAITING: Final = 256
"""Packets that wait for retransmission; the browser requests the others again."""


@dataclass(slots=True)
class UnderWay:
    """A picture whose packets leave at the pace of their train, the next one at `due_s`."""

    picture: LanePicture
    train: Train
    packets: deque[rtp.Packet]
    due_s: float


class PictureSender(Sender):
    """Sends the best picture when the link is free, and retransmits lost packets."""

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
        super().__init__(context, lane)
        self._lane = lane
        self._packetizer = _packetizer(codec)
        self._round_trip_s = round_trip_s
        self._on_keyframe_wanted = on_keyframe_wanted
        self.shows_at_once = True
        """Whether the browser reports pictures even if it shows them at once; Firefox does not."""
        self._playout_delay: rtp.PlayoutDelay | None = None
        self._under_way: UnderWay | None = None
        self._history = RetransmissionBuffer()
        self._retransmissions = Retransmissions()
        self._requested: dict[int, None] = {}
        self._rtx_number = random.getrandbits(15)

    @property
    def is_busy(self) -> bool:
        """Whether a picture is leaving or waiting, or a retransmission is waiting."""
        return self._under_way is not None or bool(self._requested) or not self._lane.is_empty

    def set_playout_delay(self, least_ms: float) -> bool:
        """Set the browser's playout delay for pictures; False if it supports none."""
        # Two zeros make Chromium show a picture at once (its low-latency renderer). The values
        # are equal because Chromium would choose within a range.
        steps = min(max(round(least_ms / 10), 0), 4095)
        is_at_once = steps == 0 and not self.shows_at_once
        self._playout_delay = rtp.PlayoutDelay(steps, _NOT_AT_ONCE_10MS if is_at_once else steps)
        return self._ids.playout_delay is not None

    def handle_nack(self, numbers: Sequence[int]) -> None:
        for number in numbers:
            if len(self._requested) < _MOST_WAITING and number in self._history:
                self._requested[number] = None
        if self._requested:
            self._wake()

    def handle_keyframe_request(self) -> None:
        self._on_keyframe_wanted()

    def _work(self) -> float | None:
        while True:
            now_s = self._now_s()
            if self._under_way is not None:
                if (wait_s := self._send_due(self._under_way, now_s)) is not None:
                    return wait_s
            elif not self._requested and self._lane.is_empty:
                return None
            elif (wait_s := self._free_in_s(now_s)) > TICK_S:
                return min(wait_s, ASK_AGAIN_S)
            elif self._retransmit_next(now_s):
                continue
            elif (picture := self._lane.pop_next()) is not None:
                self._under_way = self._packetize(picture, now_s)
            else:
                return None

    def _free_in_s(self, now_s: float) -> float:
        """Return how long the next transmission has to wait."""
        return self._tap.free_in_s(now_s)

    def _plan_train(self, size_bytes: int, now_s: float) -> Train:
        """Return the train in which a picture of this size leaves."""
        return self._tap.congestion.plan_train(size_bytes, now_s)

    def _packetize(self, picture: LanePicture, now_s: float) -> UnderWay:
        train = self._plan_train(len(picture.data), now_s)
        captured_ntp = self._captured_ntp(picture)
        first_less = rtp.first_more_bytes(self._ids, self._playout_delay, captured_ntp)
        payloads = self._packetizer(picture, train.payload_bytes, first_less)
        timestamp = (self.origin + picture.pts) % UINT32
        packets = deque(
            rtp.Packet(
                payload_type=self._payload_type,
                sequence_number=self._next_number(),
                ssrc=self.ssrc,
                timestamp=timestamp,
                marker=index == len(payloads) - 1,
                head=head,
                payload=piece,
                playout_delay=self._playout_delay if index == 0 else None,
                captured_ntp=captured_ntp if index == 0 else None,
            )
            for index, (head, piece) in enumerate(payloads)
        )
        return UnderWay(picture, train, packets, now_s)

    def _send_due(self, under_way: UnderWay, now_s: float) -> float | None:
        """Send the packets that are due together; return when the next is, None after the last."""
        due: list[rtp.Packet] = []
        while under_way.packets and under_way.due_s - now_s <= TICK_S:
            if len(due) == _MOST_TOGETHER:
                break
            packet = under_way.packets.popleft()
            due.append(packet)
            under_way.due_s += gap_s(wire_bytes(packet), under_way.train.pace_bps)
        self._history.add(due, now_s)
        self._send_packets(due, now_s, train=under_way.train.number)
        if under_way.packets:
            return under_way.due_s - now_s
        self._finish(under_way)
        return None

    def _finish(self, under_way: UnderWay) -> None:
        """Record that the picture has left."""
        self._under_way = None
        self._note_sent(under_way.picture)

    def _retransmit_next(self, now_s: float) -> bool:
        """Retransmit the first requested packet that may be; return whether there was one."""
        while self._requested:
            number = next(iter(self._requested))
            del self._requested[number]
            kept = self._history.get(number)
            if kept is None or not self._retransmissions.is_due(
                number, self._round_trip_s(), now_s
            ):
                continue
            lost, sent_s = kept
            age_s = now_s - sent_s
            if self._tap.congestion.may_retransmit(wire_bytes(lost), age_s, now_s):
                self._retransmit(lost, now_s)
                return True
        return False

    def _retransmit(self, lost: rtp.Packet, now_s: float) -> None:
        number = lost.sequence_number
        self._retransmissions.sent(number, now_s)
        again = lost._replace(playout_delay=None, captured_ntp=None)
        if self._extra_payload_type is not None:
            # RFC 4588: the original sequence number precedes the payload.
            again = again._replace(
                payload_type=self._extra_payload_type,
                sequence_number=self._rtx_number,
                ssrc=self.rtx_ssrc,
                head=number.to_bytes(2, "big") + lost.head,
            )
            self._rtx_number = (self._rtx_number + 1) % UINT16
        self._transmit([again], now_s, kind="repeat")


def _packetizer(codec: Literal["vp8", "h264"]) -> Callable[[LanePicture, int, int], list[Payload]]:
    """Return what turns a picture, `max_bytes` and `first_less` into payloads (`split_evenly`)."""
    if codec == "h264":
        return lambda picture, max_bytes, _less: h264.packets(picture.data, max_bytes=max_bytes)
    vp8 = Vp8Packetizer(picture_id=random.getrandbits(15), tl0_picidx=random.getrandbits(8))
    return lambda picture, max_bytes, first_less: vp8.packets(
        picture.data,
        layer=picture.layer,
        sync=picture.sync,
        droppable=picture.droppable,
        keyframe=picture.keyframe,
        max_bytes=max_bytes,
        first_less=first_less,
    )
