"""Receives the voice of one page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ProtocolError
from wax.rtc import private, voice_packet

if TYPE_CHECKING:
    from collections.abc import Callable

    from aiortc import RTCRtpReceiver
    from aiortc.rtcrtpparameters import RTCRtpReceiveParameters

    from wax.voice.packet import VoicePacket

_OPUS: Final = "audio/opus"


class VoiceReceiver(private.ReceiverInPlace):
    """Hands over each Opus packet; whether anybody hears it is decided elsewhere.

    `on_packet` gets None for an unreadable packet, and must not raise.
    """

    def __init__(
        self, stock: RTCRtpReceiver, on_packet: Callable[[VoicePacket | None], None]
    ) -> None:
        super().__init__(stock)
        self._on_packet = on_packet
        self._payload_type: int | None = None

    def start_receiving(self, parameters: RTCRtpReceiveParameters) -> None:
        self._payload_type = next(
            (one.payloadType for one in parameters.codecs if one.mimeType.lower() == _OPUS), None
        )

    def handle_rtp(self, packet: bytes) -> None:
        if self._payload_type is None:
            return
        try:
            voice = voice_packet.read(packet, self._payload_type)
        except ProtocolError:
            self._on_packet(None)
            return
        if voice is not None:
            self._on_packet(voice)
