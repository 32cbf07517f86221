"""Sends sound to one browser, each packet as soon as it is ready."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.rtc.payload.red import red_payload
from wax.rtc.rtp import Packet
from wax.rtc.sender import UINT32, Sender, SenderContext

if TYPE_CHECKING:
    from aiortc.rtcrtpparameters import RTCRtpSendParameters

    from wax.encode.encoded import EncodedSound
    from wax.rtc.lane import SoundLane

_MAX_BYTES: Final = 1200


class SoundSender(Sender):
    """Sends sound as soon as it is ready, and repeats earlier sound on lossy links.

    Lost sound is not retransmitted: it would be late, and the next packets repeat it.
    """

    kind = "audio"
    _extra_name = "red"

    def __init__(self, context: SenderContext, *, lane: SoundLane) -> None:
        super().__init__(context, lane)
        self._lane = lane

    def start_sending(self, parameters: RTCRtpSendParameters) -> None:
        super().start_sending(parameters)
        self._lane.set_redundancy(is_accepted=self._extra_payload_type is not None)

    def _work(self) -> None:
        while (sound := self._lane.pop_next()) is not None:
            now_s = self._now_s()
            self._send_packets([self._packet(sound)], now_s)
            self._note_sent(sound)

    def _packet(self, sound: EncodedSound) -> Packet:
        payload_type, payload = self._payload_type, sound.data
        has_redundancy = self._extra_payload_type is not None
        earlier = self._lane.packets_to_repeat(sound) if has_redundancy else ()
        if earlier:
            payload = red_payload(
                payload,
                [(sound.pts - one.pts, one.data) for one in earlier],
                payload_type=payload_type,
                max_bytes=_MAX_BYTES,
            )
            payload_type = self._extra_payload_type or payload_type
        return Packet(
            payload_type=payload_type,
            sequence_number=self._next_number(),
            ssrc=self.ssrc,
            timestamp=(self.origin + sound.pts) % UINT32,
            marker=True,
            payload=payload,
            captured_ntp=self._captured_ntp(sound),
        )
