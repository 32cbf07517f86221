"""A peer that offers: a rendition, the sound, or both, to a media server that passes them on."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import structlog
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from wax.congestion.sender_side import SenderSideControl
from wax.errors import SignallingError
from wax.rtc import private, rtp
from wax.rtc.codecs import prefer
from wax.rtc.offered import with_extensions
from wax.rtc.picture_sender import PictureSender
from wax.rtc.sender import SenderContext
from wax.rtc.sound_sender import SoundSender
from wax.rtc.transport_tap import TransportTap

if TYPE_CHECKING:
    from collections.abc import Callable

    from aiortc.rtcrtptransceiver import RTCRtpTransceiver

    from wax.clock import Clock
    from wax.rtc.lane import PictureLane, SoundLane
    from wax.rtc.sender import Sender
    from wax.streams.interface import Codecs, Kind

_LOG = structlog.get_logger(__name__)

_CLOSE_S: Final = 2.0
_EXTENSIONS: Final = (rtp.TRANSPORT_SEQUENCE, rtp.CAPTURE_TIME)


class Publisher:
    """Lives for one session: `offer`, `accept`, `connected`, `close`.

    `on_keyframe_wanted` is called where somebody who watches needs one. A lane that is None is not
    offered.
    """

    def __init__(
        self,
        *,
        codecs: Codecs,
        video: PictureLane | None,
        audio: SoundLane | None,
        clock: Clock,
        on_keyframe_wanted: Callable[[], None],
    ) -> None:
        self._codecs = codecs
        self._clock = clock
        self._changed = asyncio.Event()
        self._tap = TransportTap(SenderSideControl(_ignore), clock.now_s, _nothing)
        self._pc = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._pc.on("connectionstatechange", self._changed.set)
        self._senders: list[Sender] = []
        if audio is not None:
            transceiver = self._transceiver("audio")
            self._put(transceiver, SoundSender(self._context("audio", transceiver), lane=audio))
        if video is not None:
            transceiver = self._transceiver("video")
            picture = PictureSender(
                self._context("video", transceiver),
                lane=video,
                codec=codecs.video,
                round_trip_s=self._round_trip_s,
                on_keyframe_wanted=on_keyframe_wanted,
            )
            self._put(transceiver, picture)

    @property
    def is_alive(self) -> bool:
        """Whether it is connected and every sender works."""
        states = ("connected", "connecting", "new")
        return self._pc.connectionState in states and not any(one.failed for one in self._senders)

    @property
    def heard_s(self) -> float | None:
        """When the other end last reported on any stream; it does so each second."""
        return max((one.heard_s for one in self._senders if one.heard_s is not None), default=None)

    async def offer(self) -> str:
        """Return the offer, with every candidate."""
        offer = await self._pc.createOffer()
        sdp = with_extensions(offer.sdp, _EXTENSIONS)
        await self._pc.setLocalDescription(RTCSessionDescription(sdp, "offer"))
        return self._pc.localDescription.sdp

    async def accept(self, answer: str) -> None:
        """Take the answer; raises `SignallingError` for one that cannot be used."""
        try:
            await self._pc.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        except Exception as error:
            # aiortc's parser raises all sorts of errors.
            raise SignallingError(f"the answer cannot be used: {error}") from error
        private.widen(self._pc, _EXTENSIONS)  # before the senders begin

    async def connected(self) -> None:
        """Wait until it sends; raises `ConnectionError` when it fails instead."""
        while self._pc.connectionState != "connected":
            if not self.is_alive:
                raise ConnectionError(f"the connection is {self._pc.connectionState}")
            self._changed.clear()
            await self._changed.wait()

    async def close(self) -> None:
        """Close for good; bounded, safe to call twice."""
        try:
            async with asyncio.timeout(_CLOSE_S):
                await self._pc.close()
        except Exception:
            _LOG.exception("a publisher did not close cleanly")
        finally:
            private.break_circles(self._pc)

    def _transceiver(self, kind: Kind) -> RTCRtpTransceiver:
        transceiver = self._pc.addTransceiver(kind, direction="sendonly")
        prefer(transceiver, self._codecs.audio if kind == "audio" else self._codecs.video)
        return transceiver

    def _put(self, transceiver: RTCRtpTransceiver, sender: Sender) -> None:
        private.put_sender(transceiver, sender)
        self._senders.append(sender)

    def _context(self, kind: Kind, transceiver: RTCRtpTransceiver) -> SenderContext:
        return SenderContext(
            stock=transceiver.sender,
            rate_hz=self._codecs.rates_hz[kind],
            tap=self._tap,
            clock=self._clock,
            on_sent=_ignore,
        )

    def _round_trip_s(self) -> float | None:
        trips = [one.round_trip_s for one in self._senders if one.round_trip_s is not None]
        return min(trips, default=None)


def _ignore(*_: object) -> None: ...


def _nothing() -> None: ...
