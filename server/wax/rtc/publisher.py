"""A peer that offers a rendition, the sound, or both to a media server that forwards them."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

import structlog
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from wax.congestion.sender_side import SenderSideControl
from wax.errors import SignallingError
from wax.rtc import private, rtp
from wax.rtc.codec_preference import prefer
from wax.rtc.offer_extensions import with_extensions
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
_EXTENSIONS: Final = (rtp.CAPTURE_TIME,)
"""Not transport-wide feedback: LiveKit sends it after twenty packets, so a sender that waits for it
before sending more waits for ever. Receiver reports tell of the loss."""


@dataclass(slots=True)
class _Sent:
    """When the first and the last packet since the newest report were sent, in seconds."""

    first_s: float
    last_s: float


class Publisher:
    """Lives for one session: `offer`, `accept`, `connected`, `close`.

    `on_keyframe_wanted` is called when a viewer needs a keyframe. A lane that is None is not
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
        private.mark_other_end_known(self._pc)
        self._pc.on("connectionstatechange", self._changed.set)
        self._senders: list[Sender] = []
        self._unanswered: dict[Kind, _Sent] = {}
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
        """Whether it is connected or connecting, and every sender works."""
        states = ("connected", "connecting", "new")
        return self._pc.connectionState in states and not any(one.failed for one in self._senders)

    @property
    def unheard_s(self) -> float:
        """How long packets have been sent without a report; 0 before the first packet.

        A receiver reports each second on what arrives, but not on a silent source.
        """
        return max((self._unheard_s(one) for one in self._senders), default=0.0)

    async def offer(self) -> str:
        """Return the offer, with every candidate."""
        offer = await self._pc.createOffer()
        sdp = with_extensions(offer.sdp, _EXTENSIONS)
        await self._pc.setLocalDescription(RTCSessionDescription(sdp, "offer"))
        return self._pc.localDescription.sdp

    async def accept(self, answer: str) -> None:
        """Apply the answer; raises `SignallingError` if it cannot be used."""
        try:
            await self._pc.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        except Exception as error:
            # aiortc's parser raises all sorts of errors.
            raise SignallingError(f"the answer cannot be used: {error}") from error
        private.widen(self._pc, _EXTENSIONS)  # before the senders start

    async def connected(self) -> None:
        """Wait until it is connected; raises `ConnectionError` if it fails instead."""
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
            private.break_cycles(self._pc)

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
            on_sent=partial(self._on_sent, kind),
        )

    def _unheard_s(self, sender: Sender) -> float:
        sent = self._unanswered.get(sender.kind)
        if sent is None or _answered(sender, sent.first_s):
            return 0.0
        return sent.last_s - sent.first_s

    def _on_sent(self, kind: Kind, *_: object) -> None:
        now_s = self._clock.now_s()
        sent = self._unanswered.get(kind)
        sender = next((one for one in self._senders if one.kind == kind), None)
        if sent is None or (sender is not None and _answered(sender, sent.first_s)):
            self._unanswered[kind] = _Sent(now_s, now_s)
        else:
            sent.last_s = now_s

    def _round_trip_s(self) -> float | None:
        trips = [one.round_trip_s for one in self._senders if one.round_trip_s is not None]
        return min(trips, default=None)


def _answered(sender: Sender, sent_s: float) -> bool:
    return sender.heard_s is not None and sender.heard_s >= sent_s


def _ignore(*_: object) -> None: ...


def _nothing() -> None: ...
