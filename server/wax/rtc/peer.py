"""One browser's peer connection: sound and pictures out, optional voice in, two data channels."""

from __future__ import annotations

import asyncio
import weakref
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, Protocol

import structlog
from aiortc import RTCBundlePolicy, RTCPeerConnection, RTCSessionDescription

from wax.errors import SignallingError
from wax.rtc import private, private_association, rtp
from wax.rtc.camera_sender import CameraSender
from wax.rtc.codec_preference import prefer
from wax.rtc.offer_extensions import with_extensions
from wax.rtc.picture_sender import PictureSender
from wax.rtc.sender import Sender, SenderContext
from wax.rtc.signalling import is_firefox, pictures, takes
from wax.rtc.sound_sender import SoundSender
from wax.rtc.transport_tap import TransportTap
from wax.rtc.voice_receiver import VoiceReceiver
from wax.sentence import Sentence
from wax.weak_callback import weak_callback

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aiortc import RTCDataChannel
    from aiortc.rtcrtptransceiver import RTCRtpTransceiver

    from wax.clock import Clock
    from wax.edge.turnstile import Meter
    from wax.rtc.lane import Encoded
    from wax.rtc.network import Network
    from wax.streams.interface import CameraLane, Codecs, Kind, Lanes
    from wax.voice.packet import VoicePacket

_LOG = structlog.get_logger(__name__)

_ANSWER_S: Final = 10.0
_CLOSE_S: Final = 2.0
_CLOCK_EVERY_S: Final = 10.0
_MAX_BUFFERED_BYTES: Final = 262_144
"""A page this far behind will not catch up; its peer is closed, and it reconnects."""

_ACKNOWLEDGE_S: Final = 0.2
_EXTENSIONS: Final = (rtp.TRANSPORT_SEQUENCE, rtp.PLAYOUT_DELAY)

_UINT32: Final = 2**32

Channel = Literal["drive", "state"]


class PeerEvents(Protocol):
    """A peer's events for its viewer; the handlers must not raise."""

    def connected(self) -> None: ...

    def ready(self) -> None:
        """Both data channels are open."""
        ...

    def network_changed(self) -> None:
        """Handle a browser that has switched to another network."""
        ...

    def received(self, channel: Channel, data: str | bytes) -> None: ...

    def keyframe_wanted(self, camera: int | None = None) -> None:
        """Handle a browser that cannot decode this camera, or with None the driving view."""
        ...

    def feedback_refused(self) -> None:
        """Handle invalid feedback from the browser."""
        ...

    def rtp_clock(self, kind: Kind, rtp: int, captured_s: float) -> None:
        """Handle the RTP time of a packet whose content was captured at `captured_s`."""
        ...

    def closed(self, peer: Peer) -> None:
        """Handle the end of this peer, possibly after the next one has replaced it."""
        ...


class Peer:
    """A peer for one offer, the page's or its own, answered once and closed once.

    A reconnect is a new peer.

    `on_voice` gets the packets of the page's microphone, and None for each unreadable one; it must
    not raise. Without it nothing is received. The driving view's lane has precedence over the
    cameras'. `meter` is charged for what the page sends.
    """

    def __init__(
        self,
        *,
        network: Network,
        meter: Meter,
        codecs: Codecs,
        lanes: Lanes,
        events: PeerEvents,
        clock: Clock,
        round_trip_s: Callable[[], float | None],
        on_voice: Callable[[VoicePacket | None], None] | None = None,
    ) -> None:
        self._network = network
        self._meter = meter
        self._events = events
        self._codecs = codecs
        self._clock = clock
        self._congestion = lanes.congestion
        self._round_trip_s = round_trip_s
        self._tap = TransportTap(lanes.congestion, clock.now_s, events.feedback_refused)
        self._channels: dict[str, RTCDataChannel] = {}
        self._clock_told_s: dict[Kind, float] = {}
        self._closed = False
        self._is_offered = False
        self._configuration = network.configuration()
        self._closing: asyncio.Task[None] | None = None
        with network.reached(meter, weak_callback(self._network_changed)):
            self._pc = RTCPeerConnection(self._configuration)
            picture = self._transceiver("video")
        self._picture = PictureSender(
            self._context("video", picture),
            lane=lanes.picture,
            codec=codecs.video,
            round_trip_s=round_trip_s,
            on_keyframe_wanted=events.keyframe_wanted,
        )
        private.put_sender(picture, self._picture)
        self._senders: dict[Kind, Sender] = {"video": self._picture}
        self._sound_lane = lanes.sound
        self._on_voice = on_voice
        self._camera_lanes = lanes.cameras
        self._cameras: list[CameraSender] = []
        self._pc.on("connectionstatechange", self._state_changed)
        self._pc.on("datachannel", self._channel_opened)

    async def answer(self, offer: str) -> str:
        """Answer a checked offer; raises `SignallingError` and closes the peer on failure.

        The work is spread over several passes of the event loop, so that none is long.
        """
        await self._attempt(self._answer(offer))
        return self._pc.localDescription.sdp

    async def offer(self) -> str:
        """Offer to a browser that cannot; it answers to `accept`. Raises as `answer` does.

        There is room for the driving view, the sound and the data channels, not for the cameras.
        """
        await self._attempt(self._offer())
        return self._pc.localDescription.sdp

    async def accept(self, answer: str) -> None:
        """Apply a checked answer to our offer, once; raises as `answer` does."""
        if not self._is_offered:
            raise SignallingError(Sentence("request.unanswerable"))
        self._is_offered = False
        await self._attempt(self._apply(RTCSessionDescription(answer, "answer")))

    async def _attempt(self, step: Awaitable[None]) -> None:
        try:
            with self._network.reached(self._meter, weak_callback(self._network_changed)):
                async with asyncio.timeout(_ANSWER_S):
                    await step
        except Exception as error:
            # aiortc's parser raises all sorts of errors; the page needs only one.
            _LOG.info("offer refused", error=repr(error))
            await self.close()
            raise SignallingError(Sentence("request.unanswerable")) from error

    async def _answer(self, offer: str) -> None:
        await asyncio.sleep(0)
        self._add_sound()
        await self._add_cameras(offer)
        await asyncio.sleep(0)
        await self._apply(RTCSessionDescription(offer, "offer"))
        answer = await self._pc.createAnswer()
        await asyncio.sleep(0)
        await self._pc.setLocalDescription(answer)

    async def _offer(self) -> None:
        # aiortc bundles our offer only if told so before there is a second transport.
        self._configuration.bundlePolicy = RTCBundlePolicy.MAX_BUNDLE
        await asyncio.sleep(0)
        self._add_sound()
        private.offer_channels(self._pc)
        await asyncio.sleep(0)
        sdp = (await self._pc.createOffer()).sdp
        if self._congestion.uses_feedback:
            sdp = with_extensions(sdp, _EXTENSIONS)
        await self._pc.setLocalDescription(RTCSessionDescription(sdp, "offer"))
        self._is_offered = True

    async def _apply(self, theirs: RTCSessionDescription) -> None:
        """Set the page's description, and how we receive; nothing is sent before both are set."""
        self._picture.shows_at_once = not is_firefox(theirs.sdp)
        await self._pc.setRemoteDescription(theirs)
        await asyncio.sleep(0)
        private.meter_receiving(self._pc, self._meter)
        if self._congestion.uses_feedback:
            private.widen(self._pc, _EXTENSIONS)
        if self._pc.sctp is not None:
            association = private_association.bound_association(self._pc.sctp, self._exceeded)
            private.report_authenticated(self._pc.sctp)
            private_association.delay_acknowledgements(
                self._pc.sctp, association.acknowledgement, _ACKNOWLEDGE_S
            )

    @property
    def is_alive(self) -> bool:
        """False once closed, or if a sender failed."""
        senders = (*self._senders.values(), *self._cameras)
        return not self._closed and not any(one.failed for one in senders)

    def set_playout_delay(self, least_ms: float) -> bool:
        """Set the browser's least playout delay for pictures; False if it supports none."""
        return self._picture.set_playout_delay(least_ms)

    def send(self, channel: Channel, text: str) -> None:
        """Send, or drop the text if the channel is not open or has too long a backlog."""
        found = self._channels.get(channel)
        if found is None or found.readyState != "open":
            return
        if found.bufferedAmount > _MAX_BUFFERED_BYTES:
            if channel == "state":
                _LOG.info("a viewer has fallen too far behind; closing the peer")
                self.abandon()
            return
        found.send(text)

    def abandon(self) -> None:
        """Close from code that cannot await."""
        if not self._closed:
            self._closing = asyncio.create_task(self.close(), name="close peer")

    async def close(self) -> None:
        """Close for good; bounded, safe to call twice."""
        if self._closed:
            return
        self._closed = True
        try:
            async with asyncio.timeout(_CLOSE_S):
                await self._pc.close()
        except Exception:
            # A half-closed peer counts as closed: it must not occupy the viewer's place.
            _LOG.exception("a peer did not close cleanly")
        finally:
            private.break_cycles(self._pc)
            self._events.closed(self)

    def rtp_time(self, kind: Kind, pts: int) -> int:
        """Return the RTP time of this media time."""
        return (self._senders[kind].origin + pts) % _UINT32

    def media_time(self, kind: Kind, rtp_time: int) -> int:
        """Return the media time modulo 2³² of an RTP time."""
        return (rtp_time - self._senders[kind].origin) % _UINT32

    def _transceiver(self, kind: Kind, *, receives: bool = False) -> RTCRtpTransceiver:
        direction = "sendrecv" if receives else "sendonly"
        transceiver = self._pc.addTransceiver(kind, direction=direction)
        prefer(transceiver, self._codecs.audio if kind == "audio" else self._codecs.video)
        return transceiver

    def _add_sound(self) -> None:
        sound = self._transceiver("audio", receives=self._on_voice is not None)
        sender = SoundSender(self._context("audio", sound), lane=self._sound_lane)
        private.put_sender(sound, sender)
        if self._on_voice is not None:
            private.put_receiver(sound, VoiceReceiver(sound.receiver, self._on_voice))
        self._senders["audio"] = sender

    async def _add_cameras(self, offer: str) -> None:
        """Send the cameras that the page has room and a codec for; other sections stay inactive."""
        count = pictures(offer) - 1
        for number in range(count):
            await asyncio.sleep(0)
            camera = self._camera_lanes[number] if number < len(self._camera_lanes) else None
            if camera is None or not takes(offer, number + 1, camera.codec):
                self._further_picture("inactive")
                continue
            sender = self._camera(number, camera)
            sender.shows_at_once = self._picture.shows_at_once
            sender.set_playout_delay(0.0)
            self._cameras.append(sender)

    def _camera(self, number: int, camera: CameraLane) -> CameraSender:
        transceiver = self._further_picture("sendonly")
        prefer(transceiver, camera.codec)
        events = self._events
        sender = CameraSender(
            replace(self._context("video", transceiver), on_sent=_ignore),
            lane=camera.lane,
            codec=camera.codec,
            round_trip_s=self._round_trip_s,
            on_keyframe_wanted=lambda: events.keyframe_wanted(number),
            driving_view=self._picture,
        )
        private.put_sender(transceiver, sender)
        return sender

    def _further_picture(self, direction: str) -> RTCRtpTransceiver:
        transceiver = self._pc.addTransceiver("video", direction=direction)
        private.follow_bundle(transceiver)
        return transceiver

    def _context(self, kind: Kind, transceiver: RTCRtpTransceiver) -> SenderContext:
        peer = weakref.proxy(self)  # a strong reference would keep a closed peer alive
        return SenderContext(
            stock=transceiver.sender,
            rate_hz=self._codecs.rates_hz[kind],
            tap=self._tap,
            clock=self._clock,
            on_sent=lambda sent: peer._sent(kind, sent),
        )

    @property
    def newest_picture_s(self) -> float | None:
        """Capture time of the newest driving-view picture sent, None before the first."""
        return self._picture.newest_captured_s

    def _sent(self, kind: Kind, sent: Encoded) -> None:
        now_s = self._clock.now_s()
        if now_s - self._clock_told_s.get(kind, float("-inf")) < _CLOCK_EVERY_S:
            return
        if "state" not in self._channels:
            return
        self._clock_told_s[kind] = now_s
        self._events.rtp_clock(kind, self.rtp_time(kind, sent.pts), sent.captured_s)

    def _state_changed(self) -> None:
        state = self._pc.connectionState
        if state == "connected":
            self._events.connected()
        elif state in ("closed", "failed"):
            self.abandon()

    def _network_changed(self) -> None:
        if self._pc.connectionState != "connected":
            return  # a connecting browser tries one address after another
        self._tap.forget()
        self._events.network_changed()

    def _exceeded(self, why: str) -> None:
        _LOG.warning("SCTP limits exceeded; closing the peer", why=why)
        self.abandon()

    def _channel_opened(self, channel: RTCDataChannel) -> None:
        name = _channel_name(channel.label)
        if name is None or name in self._channels:
            _LOG.info("unknown data channel ignored", label=channel.label[:32])
            return
        self._channels[name] = channel
        channel.on("message", lambda data: self._events.received(name, data))
        channel.on("close", self.abandon)
        if len(self._channels) == 2:
            self._events.ready()


def _ignore(_sent: Encoded) -> None:
    """Ignore the capture time of an additional camera: no decision depends on its age."""


def _channel_name(label: str) -> Channel | None:
    return "drive" if label == "drive" else "state" if label == "state" else None
