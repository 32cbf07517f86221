"""A viewer's link without a clock: the lab's model of a network between a sender and a browser.

The sender is as large as it has to be: sound at once, pictures in temporal layers that wait for
the pacer, trains at their pace. The browser's clock has an origin and a drift of its own, and
tells of every packet as transport-wide feedback does, over the way back.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from heapq import heappop, heappush
from random import Random
from typing import TYPE_CHECKING, Any

from tests.link.model import Direction
from tests.link.profile import Profile, load

from wax.config import Settings
from wax.sync.delivery import Delivery, LinkEstimate
from wax.sync.estimate import LinkEstimator
from wax.sync.ladder import Ladder
from wax.sync.pacer import Pacer, gap_s
from wax.sync.serving import Rung, Serving, SoundForm

if TYPE_CHECKING:
    from collections.abc import Callable

HEADERS_BYTES = 60
_TICK_S = 0.00025
"""What transport-wide feedback tells arrivals in."""
_LAYERS = (0, 2, 1, 2)
_WEIGHTS = (1.6, 0.8, 0.8)
_KEYFRAME = 3.0


def default_rungs() -> list[Rung]:
    """Return the ladder of the default configuration, VP8 with its three temporal layers."""
    return [
        Rung(one.name, one.size, one.fps, one.bitrate_bps, 2) for one in Settings().video.renditions
    ]


def default_sounds() -> list[SoundForm]:
    """Return the forms of the default configuration that an observer's link chooses of."""
    forms, least_mu_ms = Settings().audio.forms, Settings().sync.observer.least_audio_mu_ms
    return [SoundForm(one.mu_ms, one.bitrate_bps) for one in forms if one.mu_ms >= least_mu_ms]


def profile(name: str, **down: Any) -> Profile:
    """Return a profile of the lab, where asked with another way to the browser."""
    found = load(name)
    return found.model_copy(update={"down": found.down.model_copy(update=down)}) if down else found


@dataclass(slots=True)
class Packet:
    sent_s: float
    size_bytes: int
    kind: str
    train: int | None = None
    captured_s: float | None = None
    last: bool = False


@dataclass(slots=True)
class Picture:
    captured_s: float
    layer: int
    keyframe: bool
    size_bytes: int


@dataclass(slots=True)
class Record:
    """What happened, by the time at the server."""

    estimates: list[tuple[float, LinkEstimate]] = field(default_factory=list)
    servings: list[tuple[float, Serving]] = field(default_factory=list)
    pictures: list[tuple[float, float]] = field(default_factory=list)
    """When each came to the browser, and how old it was then."""
    sounds: list[tuple[float, float]] = field(default_factory=list)
    lost_sounds: int = 0
    sent_sounds: int = 0

    def changes(self, from_s: float = 0.0) -> list[tuple[float, Rung | None]]:
        """Return when which rung was chosen, the one at `from_s` first."""
        out: list[tuple[float, Rung | None]] = []
        for now_s, serving in self.servings:
            if now_s < from_s and out:
                out[0] = (now_s, serving.rung)
            elif not out or out[-1][1] != serving.rung:
                out.append((now_s, serving.rung))
        return out

    def at(self, now_s: float) -> Serving:
        return [serving for at_s, serving in self.servings if at_s <= now_s][-1]

    def sound_ms(self, from_s: float, until_s: float, share: float) -> float:
        return _quantile([age for at, age in self.sounds if from_s <= at < until_s], share) * 1000

    def picture_ms(self, from_s: float, until_s: float, share: float) -> float:
        return _quantile([age for at, age in self.pictures if from_s <= at < until_s], share) * 1000

    def fps(self, from_s: float, until_s: float) -> float:
        return sum(from_s <= at_s < until_s for at_s, _ in self.pictures) / (until_s - from_s)


def _quantile(values: list[float], share: float) -> float:
    return sorted(values)[min(int(share * len(values)), len(values) - 1)] if values else math.inf


class Loop:
    """One viewer, from encoders to feedback and back; `run` may be called again to go on."""

    def __init__(
        self,
        network: Profile,
        *,
        feedback_s: float = 0.1,
        drift: float = 50e-6,
        origin_s: float = 12345.0,
        seed: int = 1,
        size: str | None = "640x480",
        changes: bool = True,
        start_s: float = 100.0,
    ) -> None:
        self.record = Record()
        self.estimator = LinkEstimator()
        self.pacer = Pacer(self.estimator.estimate(start_s).rate_bps)
        self.ladder = Ladder(default_rungs(), default_sounds())
        self._down = Direction(network.down, seed=seed, way="down", start_s=start_s)
        self._up = Direction(network.up, seed=seed, way="up", start_s=start_s)
        if changes:
            self._down.start_changes(start_s)
            self._up.start_changes(start_s)
        self.start_s = self.now_s = start_s
        self._size = size
        self._feedback_s = feedback_s
        self._clock: Callable[[float], float] = lambda at_s: (
            round((origin_s + at_s * (1 + drift)) / _TICK_S) * _TICK_S
        )
        self._random = Random(f"{seed} pictures")  # a Random of its own, so that runs repeat
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        self._flying: deque[Packet] = deque()
        self._down_sent: dict[int, Packet] = {}
        self._up_sent: dict[int, Callable[[], None]] = {}
        self._told_until = self._arrived_until = 0
        self._history: dict[int, tuple[Packet, float | None]] = {}
        self._number = 0
        self._lane: deque[Picture] = deque()
        self._sending = False
        self._encoded: Rung | None = None
        self._since_keyframe = 0
        self.serving: Serving | None = None
        self.broken = 0
        for first in (self._decide, self._sound, self._capture, self._feedback, self._ping):
            self._at(start_s, first)

    def run(self, seconds: float) -> Record:
        end_s = self.now_s + seconds
        while True:
            wire_s = min(self._down.next_s(), self._up.next_s())
            due_s = min(wire_s, self._events[0][0])
            if due_s > end_s:
                break
            self.now_s = due_s
            if wire_s <= due_s:
                self._arrivals()
            else:
                heappop(self._events)[2]()
        self.now_s = end_s
        return self.record

    def _at(self, at_s: float, what: Callable[[], None]) -> None:
        self._count += 1
        heappush(self._events, (at_s, self._count, what))

    def _decide(self) -> None:
        now_s = self.now_s
        estimate = self.estimator.estimate(now_s)
        serving = self.ladder.decide(
            estimate, size=self._size, sound=True, sound_form=None, other_bps=4000, now_s=now_s
        )
        self.pacer.rate_bps = estimate.rate_bps
        self.record.estimates.append((now_s - self.start_s, estimate))
        if serving != self.serving:
            self.record.servings.append((now_s - self.start_s, serving))
        self.serving = serving
        self._at(now_s + 0.05, self._decide)

    def _sound(self) -> None:
        assert self.serving is not None
        form = self.serving.sound
        assert form is not None
        unit = form.bitrate_bps * form.mu_ms // 8000
        size = unit * (1 + self.serving.redundancy) + HEADERS_BYTES
        self.record.sent_sounds += 1
        self._send(Packet(self.now_s, size, "audio", captured_s=self.now_s))
        self._at(self.now_s + form.mu_ms / 1000, self._sound)

    def _ping(self) -> None:
        self._send(Packet(self.now_s, 90, "ping"))
        self._at(self.now_s + 0.5, self._ping)

    def _capture(self) -> None:
        assert self.serving is not None
        rung = self.serving.rung
        self._at(self.now_s + 1 / (rung.fps if rung else 10.0), self._capture)
        if rung is None:
            self._lane.clear()
            self._encoded = None
            return
        keyframe = rung != self._encoded
        self._encoded = rung
        self._since_keyframe = 0 if keyframe else self._since_keyframe + 1
        layer = _LAYERS[self._since_keyframe % len(_LAYERS)]
        weight = _KEYFRAME if keyframe else _WEIGHTS[layer]
        size = rung.bitrate_bps / rung.fps / 8 * weight * self._random.uniform(0.8, 1.2)
        if layer > self.serving.top_layer and not keyframe:
            return
        if keyframe:
            self._lane.clear()
        self._lane.append(Picture(self.now_s, layer, keyframe, round(size)))
        while len(self._lane) > 1 and any(picture.layer for picture in self._lane):
            upper = max(picture.layer for picture in self._lane)
            if self._lane[-1].layer == upper and sum(p.layer == upper for p in self._lane) == 1:
                break
            self._lane.remove(next(p for p in self._lane if p.layer == upper))
        if not self._sending:
            self._sending = True
            self._go()

    def _go(self) -> None:
        if not self._lane:
            self._sending = False
            return
        wait_s = self.pacer.free_in_s(self.now_s)
        if self.estimator.estimate(self.now_s).state == "blind":
            wait_s = 0.02
        if wait_s > 0:
            self._at(self.now_s + max(wait_s, 0.0005), self._go)
            return
        picture = self._lane.popleft()
        train = self.estimator.train(picture.size_bytes, self.now_s)
        count = math.ceil(picture.size_bytes / train.payload_bytes)
        self._train(picture, train.number, train.pace_bps, count)

    def _train(self, picture: Picture, number: int, pace_bps: float, left: int) -> None:
        packets = left
        size = math.ceil(picture.size_bytes / packets)
        packet = Packet(
            self.now_s, size + HEADERS_BYTES, "video", number, picture.captured_s, left == 1
        )
        self._send(packet)
        picture.size_bytes -= size
        next_s = self.now_s + gap_s(packet.size_bytes, pace_bps)
        if left > 1 and picture.size_bytes > 0:
            self._at(next_s, lambda: self._train(picture, number, pace_bps, left - 1))
        else:
            self._at(next_s, self._go)

    def _send(self, packet: Packet) -> None:
        self.pacer.spend(packet.size_bytes, self.now_s)
        self.estimator.sent(packet.size_bytes, self.now_s)
        number = -1
        if packet.kind != "ping":
            self._number += 1
            number = self._number
            self._history[number] = (packet, None)
        self._down.arrive(_named(number, packet.size_bytes), self.now_s)
        if packet.kind == "ping":
            self._pinged_s = packet.sent_s

    def _arrivals(self) -> None:
        for due_s, data in self._down.due(self.now_s):
            number = _name(data)
            if number < 0:
                self._reply(90, self._pong(self._pinged_s))
                continue
            packet, _ = self._history[number]
            self._history[number] = (packet, self._clock(due_s))
            self._arrived_until = max(self._arrived_until, number)
            at_s = due_s - self.start_s
            if packet.kind == "audio":
                self.record.sounds.append((at_s, due_s - packet.sent_s))
            elif packet.last and packet.captured_s is not None:
                self.record.pictures.append((at_s, due_s - packet.captured_s))
        for _, data in self._up.due(self.now_s):
            self._up_sent.pop(_name(data))()

    def _pong(self, sent_s: float) -> Callable[[], None]:
        return lambda: self.estimator.round_trip(self.now_s - sent_s, self.now_s)

    def _feedback(self) -> None:
        self._at(self.now_s + self._feedback_s, self._feedback)
        if self._arrived_until <= self._told_until:
            return
        told = [
            Delivery(packet.sent_s, arrived_s, packet.size_bytes, packet.kind, packet.train)  # type: ignore[arg-type]
            for packet, arrived_s in (
                self._history.pop(number)
                for number in range(self._told_until + 1, self._arrived_until + 1)
            )
        ]
        self.record.lost_sounds += sum(d.kind == "audio" and d.arrived_s is None for d in told)
        self._told_until = self._arrived_until
        self._reply(60 + 3 * len(told), lambda: self._told(told))

    def _told(self, told: list[Delivery]) -> None:
        self.estimator.delivered(told, self.now_s)
        estimate = self.estimator.estimate(self.now_s)
        self.pacer.rate_bps = estimate.rate_bps
        self.pacer.drain(estimate.queue_ms, self.now_s)

    def _reply(self, size_bytes: int, what: Callable[[], None]) -> None:
        self._count += 1
        self._up_sent[self._count] = what
        self._up.arrive(_named(self._count, size_bytes), self.now_s)


def _named(number: int, size_bytes: int) -> bytes:
    return number.to_bytes(8, "big", signed=True).ljust(size_bytes, b"\0")


def _name(data: bytes) -> int:
    return int.from_bytes(data[:8], "big", signed=True)
