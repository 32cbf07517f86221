"""A real peer of ours, with lanes, congestion control and events that are recorded."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from aiortc import RTCPeerConnection, RTCSessionDescription
from tests.rtc.networks import rich_meter

from wax.clock import SystemClock
from wax.congestion.control import CongestionControl
from wax.encode.encoded import EncodedPicture, EncodedSound
from wax.rtc import private
from wax.rtc.peer import Peer
from wax.rtc.signalling import clean_offer
from wax.streams.interface import Codecs, Lanes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.congestion.control import Delivery
    from wax.rtc.network import Network

ELSEWHERE = "127.0.0.9"


class Noted(CongestionControl):
    """Congestion control that is always open and records its calls."""

    uses_feedback = True

    def __init__(self) -> None:
        self.sent_bytes: list[tuple[int, bool]] = []
        self.told_bytes: list[int] = []
        self.lost_: list[tuple[str, float]] = []
        self.delivered_: list[Delivery] = []
        self.closed = False

    def sent(
        self, size_bytes: int, now_s: float, *, is_media: bool, has_feedback: bool = True
    ) -> None:
        self.sent_bytes.append((size_bytes, is_media))
        if has_feedback:
            self.told_bytes.append(size_bytes)

    def lost(self, share: float, now_s: float, kind: Literal["audio", "video"] = "video") -> None:
        self.lost_.append((kind, share))

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        self.delivered_ += deliveries

    def free_in_s(self, unreported_s: float | None, now_s: float) -> float:
        return 0.01 if self.closed else 0.0


class Ticking:
    """Offers a small packet every 10 ms, and notifies its listener."""

    def __init__(self) -> None:
        self.number = 0
        self._on_news: Callable[[], None] | None = None
        self.is_empty = False

    def set_listener(self, on_news: Callable[[], None]) -> None:
        self._on_news = on_news

    def _has_one(self) -> bool:
        """Return whether a packet is available, and then offer none for 10 ms."""
        if self.is_empty:
            return False
        self.is_empty = True
        asyncio.get_running_loop().call_later(0.01, self._tick)
        return True

    def _tick(self) -> None:
        self.is_empty = False
        if self._on_news is not None:
            self._on_news()

    def _next(self) -> tuple[bytes, int, float]:
        self.number += 1
        data = b"\x00\x00\x00\x01\x41" + b"\x80" * 60
        return data, 90_000 * 5 + 900 * self.number, 5 + self.number / 100


class Sounds(Ticking):
    """A lane of sound; `again` is repeated with each packet."""

    def __init__(self) -> None:
        super().__init__()
        self.again: tuple[EncodedSound, ...] = ()
        self.takes_redundancy: bool | None = None

    def pop_next(self) -> EncodedSound | None:
        return EncodedSound(*self._next(), 900) if self._has_one() else None

    def set_redundancy(self, *, is_accepted: bool) -> None:
        self.takes_redundancy = is_accepted

    def packets_to_repeat(self, sound: EncodedSound) -> tuple[EncodedSound, ...]:
        return self.again


class Pictures(Ticking):
    """A lane of pictures."""

    def pop_next(self) -> EncodedPicture | None:
        if not self._has_one():
            return None
        data, pts, captured_s = self._next()
        return EncodedPicture(data, pts, "any", keyframe=True, layer=0, captured_s=captured_s)


@dataclass
class Events:
    """Records the peer's events."""

    seen: list[tuple[str, object]] = field(default_factory=list)
    news: asyncio.Event = field(default_factory=asyncio.Event)

    def _note(self, what: str, value: object = None) -> None:
        self.seen.append((what, value))
        self.news.set()

    def connected(self) -> None:
        self._note("connected")

    def ready(self) -> None:
        self._note("ready")

    def network_changed(self) -> None:
        self._note("network_changed")

    def received(self, channel: str, data: str | bytes) -> None:
        self._note(f"received {channel}", data)

    def keyframe_wanted(self, camera: int | None = None) -> None:
        self._note("keyframe")

    def feedback_refused(self) -> None:
        self._note("feedback refused")

    def rtp_clock(self, kind: str, rtp: int, captured_s: float) -> None:
        self._note(f"clock {kind}", (rtp, captured_s))

    def closed(self, peer: Peer) -> None:
        self._note("closed")

    async def wait(self, what: str) -> object:
        async with asyncio.timeout(10):
            while True:
                for name, value in self.seen:
                    if name == what:
                        return value
                self.news.clear()
                await self.news.wait()


def peer_of(network: Network, events: Events, **more: Any) -> Peer:
    """Return a peer that always has pictures and sound; `more` overrides its parts."""
    private.install()
    lanes = Lanes(
        picture=more.pop("video", Pictures()),
        sound=more.pop("audio", Sounds()),
        congestion=more.pop("congestion", Noted()),
        cameras=more.pop("cameras", ()),
    )
    options: dict[str, Any] = {
        "meter": rich_meter(),
        "codecs": Codecs(audio="opus", video="vp8"),
        "lanes": lanes,
        "clock": SystemClock(),
        "round_trip_s": lambda: 0.5,
    }
    return Peer(network=network, events=events, **options | more)


async def agree_on_ours(peer: Peer, browser: RTCPeerConnection) -> str:
    """Have the browser answer the peer's offer; return the offer."""
    offer = await peer.offer()
    await browser.setRemoteDescription(RTCSessionDescription(offer, "offer"))
    await browser.setLocalDescription(await browser.createAnswer())
    await peer.accept(clean_offer(browser.localDescription.sdp))
    return offer


async def agree(peer: Peer, browser: RTCPeerConnection) -> str:
    """Have the peer answer the browser's offer; return the answer."""
    await browser.setLocalDescription(await browser.createOffer())
    answer = await peer.answer(clean_offer(browser.localDescription.sdp))
    await browser.setRemoteDescription(RTCSessionDescription(answer, "answer"))
    return answer
