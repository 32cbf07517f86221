"""Restricts a stream to one codec; aiortc would use the other end's first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aiortc import RTCRtpSender

if TYPE_CHECKING:
    from aiortc.rtcrtptransceiver import RTCRtpTransceiver


def prefer(transceiver: RTCRtpTransceiver, codec: str) -> None:
    """Negotiate only this codec ("vp8") and its retransmissions."""
    kind = transceiver.kind
    transceiver.setCodecPreferences(
        [
            one
            for one in RTCRtpSender.getCapabilities(kind).codecs
            if one.mimeType.lower() in (f"{kind}/{codec}", f"{kind}/rtx")
        ]
    )
