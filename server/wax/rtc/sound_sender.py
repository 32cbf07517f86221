"""The sound to one browser: each packet as soon as it is ready."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.rtc.payload.red import red_payload
from wax.rtc.sender import UINT32, Sender, SenderContext
from wax.rtc.sent_history import SentPacket

if TYPE_CHECKING:
    from aiortc.rtcrtpparameters import RTCRtpSendParameters
    from aiortc.rtp import AnyRtcpPacket

    from wax.rtc.lane import SoundLane

_MAX_BYTES: Final = 1200


class SoundSender(Sender):
    """Sends sound as soon as it is ready, and repeats earlier sound on lossy links."""

    kind = "audio"
    _extra_name = "red"

    def __init__(self, context: SenderContext, *, lane: SoundLane) -> None:
        super().__init__(context)
        self._lane = lane

    def begin(self, parameters: RTCRtpSendParameters) -> None:
        super().begin(parameters)
        self._lane.offered(redundancy=self._extra_payload_type is not None)

    async def _run_lane(self) -> None:
        while True:
            sound = await self._lane.get()
            pts = sound.pts
            payload_type, payload = self._payload_type, sound.data
            earlier = self._lane.earlier(sound) if self._extra_payload_type is not None else ()
            if earlier:
                payload = red_payload(
                    payload,
                    [(pts - one.pts, one.data) for one in earlier],
                    payload_type=payload_type,
                    max_bytes=_MAX_BYTES,
                )
                payload_type = self._extra_payload_type or payload_type
            packet = SentPacket((self.origin + pts) % UINT32, True, payload, self._now_s())
            await self._send_new(payload_type, packet)
            self._left(sound, pts)

    def _asked(self, packet: AnyRtcpPacket) -> None:
        """Do nothing: lost sound would be late, and the next packets repeat it."""
