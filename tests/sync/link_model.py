"""A model of a viewer's link without a clock: a network between a sender and a browser.

The sender's congestion control, allocator and playout policy are the product's. The model adds
sound that leaves at once, pictures in temporal layers that wait for the pacer, paced probe trains
and retransmissions. The browser's clock has its own origin and drift, and it reports every marked
packet as transport-wide feedback does, over the return path.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from heapq import heappop, heappush
from random import Random
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

from tests.link.model import Direction
from tests.link.profile import Profile, load
from tests.sync.browser_model import Browser

from wax.config.settings import Settings
from wax.config.sync import SyncSettings
from wax.congestion.allocation import Allocation, SoundEncoding, Step
from wax.congestion.allocator import Allocator
from wax.congestion.control import Delivery, LinkEstimate
from wax.congestion.pacer import gap_s
from wax.congestion.sender_side import SenderSideControl
from wax.rtc.picture_sender import ASK_AGAIN_S
from wax.rtc.retransmissions import Retransmissions
from wax.sync.audio_master import AudioMaster

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.sync.playout import PlayoutReport

HEADERS_BYTES = 60
_TICK_S = 0.00025
"""The unit of arrival times in transport-wide feedback."""
_LAYERS = (0, 2, 1, 2)
_WEIGHTS = (1.6, 0.8, 0.8)
_KEYFRAME = 3.0
_BASE_PICTURES = 4
"""With more pictures of layer 0 queued the lane drops all to a keyframe (`fanout.video_lane`)."""
_RESUME_S = 0.5
"""The least time between two keyframe requests (`streams.live`)."""
_REPORT_S = 0.25
"""How often a page reports its playout."""
_RECEIVER_REPORT_S = 1.0
"""How often a browser sends receiver reports of the picture."""
_ASK_AGAIN_S = 0.05
"""A browser repeats a NACK after a round trip, which is this on most links here."""
_GIVE_UP_S = 0.5
"""After this many NACKs the browser requests a keyframe (PLI)."""
_CHROMIUM_S = 0.05
"""How often Chromium sends feedback when the link has room for it."""


def default_steps() -> list[Step]:
    """Return the ladder of the default configuration, VP8 with its three temporal layers."""
    return [
        Step(one.name, one.size, one.fps, one.bitrate_bps, 2) for one in Settings().video.renditions
    ]


def default_sounds() -> list[SoundEncoding]:
    """Return the encodings of the default configuration that suit an observer's link."""
    settings = Settings()
    fitting = (
        one
        for one in settings.audio.encodings
        if one.mu_ms >= settings.sync.observer.least_audio_mu_ms
    )
    return [SoundEncoding(one.mu_ms, one.bitrate_bps) for one in fitting]


def profile(name: str, **down: Any) -> Profile:
    """Return a profile, if requested with another path to the browser."""
    found = load(name)
    return found.model_copy(update={"down": found.down.model_copy(update=down)}) if down else found


@dataclass(slots=True)
class Packet:
    sent_s: float
    size_bytes: int
    kind: str
    train: int | None = None
    captured_s: float | None = None
    number: int = 0
    redundancy: int = 0
    last: bool = False


@dataclass(slots=True)
class Picture:
    captured_s: float
    layer: int
    keyframe: bool
    size_bytes: int


@dataclass(slots=True)
class Record:
    """What happened, by the server's time."""

    estimates: list[tuple[float, LinkEstimate]] = field(default_factory=list)
    allocations: list[tuple[float, Allocation]] = field(default_factory=list)
    pictures: list[tuple[float, float]] = field(default_factory=list)
    """When the last packet of each came to the browser, and how old it was then."""
    shown: list[tuple[float, float]] = field(default_factory=list)
    """When each was shown, whole and held back, and how old it was then."""
    sounds: list[tuple[float, float]] = field(default_factory=list)
    lost_sounds: int = 0
    sent_sounds: int = 0
    came_bytes: list[tuple[float, int]] = field(default_factory=list)
    played: list[tuple[float, float, float]] = field(default_factory=list)
    """At each report how much of the sound was concealed so far, and played, in s."""

    def changes(self, from_s: float = 0.0) -> list[tuple[float, Step | None]]:
        """Return the times and steps of each change, beginning with the step at `from_s`."""
        out: list[tuple[float, Step | None]] = []
        for now_s, allocation in self.allocations:
            if now_s < from_s and out:
                out[0] = (now_s, allocation.step)
            elif not out or out[-1][1] != allocation.step:
                out.append((now_s, allocation.step))
        return out

    def at(self, now_s: float) -> Allocation:
        return [allocation for at_s, allocation in self.allocations if at_s <= now_s][-1]

    def sound_ms(self, from_s: float, until_s: float, share: float) -> float:
        return _quantile([age for at, age in self.sounds if from_s <= at < until_s], share) * 1000

    def picture_ms(self, from_s: float, until_s: float, share: float) -> float:
        return _quantile([age for at, age in self.pictures if from_s <= at < until_s], share) * 1000

    def fps(self, from_s: float, until_s: float) -> float:
        return sum(from_s <= at_s < until_s for at_s, _ in self.pictures) / (until_s - from_s)


def _quantile(values: list[float], share: float) -> float:
    return sorted(values)[min(int(share * len(values)), len(values) - 1)] if values else math.inf


class Link(Protocol):
    """One direction, like `Direction`; or one port of a shared one."""

    def arrive(self, packet: bytes, now_s: float) -> None: ...

    def next_s(self) -> float: ...

    def due(self, now_s: float) -> list[tuple[float, bytes]]: ...


class Loop:
    """One viewer, from encoders to playout and back; `run` may be called repeatedly."""

    def __init__(
        self,
        network: Profile,
        *,
        down: Link | None = None,
        feedback_s: float = 0.1,
        drift: float = 50e-6,
        origin_s: float = 12345.0,
        seed: int = 1,
        size: str | None = "640x480",
        drives: bool = True,
        has_feedback: bool = True,
        changes: bool = True,
        start_s: float = 100.0,
    ) -> None:
        self.record = Record()
        self.start_s = self.now_s = start_s
        self.allocation: Allocation | None = None
        self.control = SenderSideControl(self._decide)
        self.control.negotiated(has_feedback=has_feedback)
        self.control.full_feedback = drives
        self.browser = Browser()
        self._policy = AudioMaster(SyncSettings())
        self._allocator = Allocator(default_steps(), default_sounds())
        up = Direction(network.up, seed=seed, way="up", start_s=start_s)
        if down is None:
            own = Direction(network.down, seed=seed, way="down", start_s=start_s)
            if changes:
                own.start_changes(start_s)
            down = own
        if changes:
            up.start_changes(start_s)
        self._down, self._up = down, up
        self._size = size
        self._feedback_s = feedback_s
        self._clock: Callable[[float], float] = lambda at_s: (
            round((origin_s + at_s * (1 + drift)) / _TICK_S) * _TICK_S
        )
        self._random = Random(f"{seed} pictures")  # a separate Random, so that runs are repeatable
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        self._down_sent: dict[int, Packet] = {}
        self._up_sent: dict[int, Callable[[], None]] = {}
        self._unreported: dict[int, Packet] = {}
        self._arrived: dict[int, float] = {}
        self._newest = self._reported_until = 0
        self._lane: deque[Picture] = deque()
        self._sending = False
        self._encoded: Step | None = None
        self._is_cut = False
        self._asked_s = -math.inf
        self._since_keyframe = 0
        self._units = 0
        self._base: int | None = None
        self._videos: dict[int, Packet] = {}
        self._count_sent = self._came = self._reported_sent = self._reported_came = 0
        self._repeats = Retransmissions()
        self._asked: dict[int, float] = {}
        self._pli_s = -math.inf
        self._video = self._video_came = 0
        self._decide(self.control.estimate(start_s), start_s)
        for first in (
            self._sound,
            self._capture,
            self._feedback if has_feedback else self._receiver_report,
            self._ping,
            self._report,
            self._ask_again,
        ):
            self._at(start_s, first)

    def run(self, seconds: float) -> Record:
        end_s = self.now_s + seconds
        while self.next_s() <= end_s:
            self.step()
        self.now_s = end_s
        return self.record

    def next_s(self) -> float:
        """Return the time of the next event."""
        return min(self._down.next_s(), self._up.next_s(), self._events[0][0])

    def step(self) -> None:
        """Process the next event."""
        wire_s = min(self._down.next_s(), self._up.next_s())
        self.now_s = max(self.now_s, min(wire_s, self._events[0][0]))
        if wire_s <= self.now_s:
            self._arrivals()
        else:
            heappop(self._events)[2]()

    def _at(self, at_s: float, what: Callable[[], None]) -> None:
        self._count += 1
        heappush(self._events, (at_s, self._count, what))

    def _decide(self, estimate: LinkEstimate, now_s: float) -> None:
        allocation = self._allocator.decide(
            estimate,
            size=self._size,
            sound=True,
            sound_encodings=None,
            other_bps=self.control.other_bps,
            now_s=now_s,
        )
        self.record.estimates.append((now_s - self.start_s, estimate))
        if allocation.tries and not (self.allocation and self.allocation.tries):
            self.control.try_more(now_s)
        if allocation != self.allocation:
            self.record.allocations.append((now_s - self.start_s, allocation))
        may_resume = estimate.state in ("starting", "steady") and self._is_cut
        may_resume &= now_s - self._asked_s >= _RESUME_S
        if may_resume and self.control.is_free_for_keyframe(now_s):
            self._asked_s, self._encoded = now_s, None
        self.allocation = allocation

    def _sound(self) -> None:
        assert self.allocation is not None
        encoding, redundancy = self.allocation.sound, self.allocation.redundancy
        assert encoding is not None
        unit = encoding.bitrate_bps * encoding.mu_ms // 8000
        size = unit * (1 + redundancy) + HEADERS_BYTES
        self.record.sent_sounds += 1
        self._units += 1
        self.browser.sound.sent(self._units, self.now_s, encoding.mu_ms / 1000)
        self._send(
            Packet(self.now_s, size, "audio", captured_s=self.now_s, number=self._units)
        ).redundancy = redundancy
        self._at(self.now_s + encoding.mu_ms / 1000, self._sound)

    def _ping(self) -> None:
        self._send(Packet(self.now_s, 90, "ping"))
        self._at(self.now_s + 0.5, self._ping)

    def _capture(self) -> None:
        assert self.allocation is not None
        step = self.allocation.step
        self._at(self.now_s + 1 / (step.fps if step else 10.0), self._capture)
        if step is None:
            self._lane.clear()
            self._encoded = None
            return
        keyframe = step != self._encoded
        self._encoded = step
        self._since_keyframe = 0 if keyframe else self._since_keyframe + 1
        layer = _LAYERS[self._since_keyframe % len(_LAYERS)]
        weight = _KEYFRAME if keyframe else _WEIGHTS[layer]
        size = step.bitrate_bps / step.fps / 8 * weight * self._random.uniform(0.8, 1.2)
        if (self._is_cut or layer > self.allocation.top_layer) and not keyframe:
            return
        if keyframe:
            self._lane.clear()
            self._is_cut = False
        self._lane.append(Picture(self.now_s, layer, keyframe, round(size)))
        while len(self._lane) > 1 and any(picture.layer for picture in self._lane):
            upper = max(picture.layer for picture in self._lane)
            if self._lane[-1].layer == upper and sum(p.layer == upper for p in self._lane) == 1:
                break
            self._lane.remove(next(p for p in self._lane if p.layer == upper))
        if sum(one.layer == 0 for one in self._lane) > _BASE_PICTURES:
            self._lane.clear()
            self._is_cut = True
        if not self._sending:
            self._sending = True
            self._go()

    def _go(self) -> None:
        if not self._lane:
            self._sending = False
            return
        unreported_s = None
        if self._unreported and self._feedback_s <= _CHROMIUM_S:  # overdue items depend on it
            unreported_s = self.now_s - next(iter(self._unreported.values())).sent_s
        wait_s = self.control.free_in_s(unreported_s, self.now_s)
        if wait_s > 0:
            self._at(self.now_s + min(max(wait_s, 0.0005), ASK_AGAIN_S), self._go)
            return
        picture = self._lane.popleft()
        train = self.control.plan_train(picture.size_bytes, self.now_s)
        count = math.ceil(picture.size_bytes / train.payload_bytes)
        before = None if picture.keyframe else self._base
        self.browser.picture.sent(train.number, picture.captured_s, count, before)
        if picture.layer == 0:
            self._base = train.number
        self._train(picture, train.number, train.pace_bps, count)

    def _train(self, picture: Picture, number: int, pace_bps: float, left: int) -> None:
        size = math.ceil(picture.size_bytes / left)
        self._video += 1
        packet = Packet(
            self.now_s, size + HEADERS_BYTES, "video", number, picture.captured_s, self._video
        )
        packet.last = left == 1
        self._videos[self._video] = packet
        self._videos.pop(self._video - 1024, None)
        self._send(packet)
        picture.size_bytes -= size
        next_s = self.now_s + gap_s(packet.size_bytes, pace_bps)
        if left > 1:
            self._at(next_s, lambda: self._train(picture, number, pace_bps, left - 1))
        else:
            self._at(next_s, self._go)

    def _send(self, packet: Packet) -> Packet:
        media = packet.kind != "ping"
        self._count += 1
        number = self._count
        train = packet.train if packet.kind == "video" else None
        if media and self.control.requests_feedback(train, self.now_s):
            self._unreported[number] = packet
        self._down_sent[number] = packet
        self._down_sent.pop(number - 20_000, None)
        self._count_sent += 1
        self._down.arrive(_named(number, packet.size_bytes), self.now_s)
        self.control.sent(packet.size_bytes, self.now_s, is_media=media, has_feedback=media)
        return packet

    def _arrivals(self) -> None:
        for due_s, data in self._down.due(self.now_s):
            number = _name(data)
            packet = self._down_sent.pop(number)
            self._came += 1
            self.record.came_bytes.append((due_s - self.start_s, packet.size_bytes))
            if packet.kind == "ping":
                self._reply(90, self._pong(packet.sent_s))
                continue
            if number in self._unreported:
                self._arrived[number] = self._clock(due_s)
                self._newest = max(self._newest, number)
            self._played(packet, due_s)
        for _, data in self._up.due(self.now_s):
            self._up_sent.pop(_name(data))()

    def _played(self, packet: Packet, due_s: float) -> None:
        if packet.kind == "audio":
            self.record.sounds.append((due_s - self.start_s, due_s - packet.sent_s))
            self.browser.sound.came(packet.number, packet.redundancy, due_s)
            return
        if packet.kind == "video":
            for missing in range(self._video_came + 1, packet.number):
                self._ask(missing)
            self._video_came = max(self._video_came, packet.number)
            if packet.last and packet.captured_s is not None:
                self.record.pictures.append((due_s - self.start_s, due_s - packet.captured_s))
        self._asked.pop(packet.number, None)
        assert packet.train is not None
        for captured_s, shown_s in self.browser.picture.came(packet.train, due_s):
            self.record.shown.append((shown_s - self.start_s, shown_s - captured_s))

    def _ask(self, number: int) -> None:
        """Send a NACK for a packet of a picture (RFC 4585)."""
        self._asked.setdefault(number, self.now_s)
        self._reply(70, lambda: self._retransmit(number))

    def _ask_again(self) -> None:
        """Repeat NACKs, and send a PLI once they have failed."""
        self._at(self.now_s + _ASK_AGAIN_S, self._ask_again)
        for number, first_s in list(self._asked.items()):
            if self.now_s - first_s < _GIVE_UP_S:
                self._ask(number)
                continue
            del self._asked[number]
            if self.now_s - self._pli_s > _GIVE_UP_S:
                self._pli_s = self.now_s
                self._reply(60, self._lose_thread)

    def _lose_thread(self) -> None:
        """Restart with a keyframe."""
        self._encoded = None

    def _retransmit(self, number: int) -> None:
        packet = self._videos.get(number)
        if packet is None:
            return
        round_trip_ms = self.control.estimate(self.now_s).round_trip_ms
        round_trip_s = None if round_trip_ms is None else round_trip_ms / 1000
        if not self._repeats.is_due(number, round_trip_s, self.now_s):
            return
        age_s = self.now_s - packet.sent_s
        if self.control.may_retransmit(packet.size_bytes, age_s, self.now_s):
            self._repeats.sent(number, self.now_s)
            self._send(
                Packet(self.now_s, packet.size_bytes + 2, "repeat", packet.train, number=number)
            )

    def _pong(self, sent_s: float) -> Callable[[], None]:
        return lambda: self.control.round_trip(self.now_s - sent_s, self.now_s)

    def _report(self) -> None:
        assert self.allocation is not None
        self._at(self.now_s + _REPORT_S, self._report)
        report = self.browser.report(self.now_s, sees=self.allocation.step is not None)
        played = (self.browser.sound.concealed_s, self.browser.sound.played_s)
        self.record.played.append((self.now_s - self.start_s, *played))
        self._reply(200, lambda: self._reported(report))

    def _reported(self, report: PlayoutReport) -> None:
        targets = self._policy.decide(
            report, self.now_s, self.control.estimate(self.now_s), self.allocation
        )
        self.browser.sound.least_s = (targets.sound_ms or 0.0) / 1000
        self.browser.picture.hold_s = (targets.picture_ms or 0.0) / 1000

    def _feedback(self) -> None:
        self._at(self.now_s + self._feedback_s, self._feedback)
        if not self._arrived:
            return
        arrived, after, until = self._arrived, self._reported_until, self._newest
        self._arrived, self._reported_until = {}, until
        self._reply(60 + 3 * len(arrived), lambda: self._told(arrived, after, until))

    def _receiver_report(self) -> None:
        """Report the share of packets lost since the last report (RFC 3550, 6.4)."""
        self._at(self.now_s + _RECEIVER_REPORT_S, self._receiver_report)
        expected, came = self._count_sent - self._reported_sent, self._came - self._reported_came
        self._reported_sent, self._reported_came = self._count_sent, self._came
        if expected:
            lost = min(max(1 - came / expected, 0.0), 1.0)
            self._reply(60, lambda: self.control.lost(lost, self.now_s))

    def _told(self, arrived: dict[int, float], after: int, until: int) -> None:
        """Match feedback with what was sent; lost feedback is never repeated."""
        told = []
        for number in [number for number in self._unreported if number <= until]:
            packet = self._unreported.pop(number)
            if number <= after:
                continue
            train = packet.train if packet.kind == "video" else None
            kind = cast("Literal['audio', 'video', 'repeat']", packet.kind)
            told.append(
                Delivery(packet.sent_s, arrived.get(number), packet.size_bytes, kind, train)
            )
        self.record.lost_sounds += sum(d.kind == "audio" and d.arrived_s is None for d in told)
        self.control.delivered(told, self.now_s)

    def _reply(self, size_bytes: int, what: Callable[[], None]) -> None:
        self._count += 1
        self._up_sent[self._count] = what
        self._up.arrive(_named(self._count, size_bytes), self.now_s)


def _named(number: int, size_bytes: int) -> bytes:
    return number.to_bytes(8, "big", signed=True).ljust(size_bytes, b"\0")


def _name(data: bytes) -> int:
    return int.from_bytes(data[:8], "big", signed=True)
