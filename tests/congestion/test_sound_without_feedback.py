"""A browser with feedback on pictures only, such as Firefox 140, over the emulated links."""

from __future__ import annotations

import math
from collections import deque
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Literal

import pytest
from tests.examples import at_length
from tests.link.model import Direction
from tests.link.profile import Change, Jitter, Profile, load

from wax.config.settings import Settings
from wax.congestion.allocation import SoundEncoding, Step
from wax.congestion.allocator import Allocator
from wax.congestion.control import Delivery
from wax.congestion.pacer import gap_s
from wax.congestion.sender_side import SenderSideControl

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate

HEADERS_BYTES = 60
BACK_S = 0.03
FEEDBACK_S = 0.1
REPORT_S = 5.0
"""The time between two receiver reports on sound in libwebrtc."""


class Viewer:
    """Sends sound at once, and pictures when the pacer lets them; its feedback is never late."""

    def __init__(self, network: Profile, *, sound_has_feedback: bool) -> None:
        self.control = SenderSideControl(self._decide)
        self.control.negotiated(has_feedback=True, kind="video")
        self.control.negotiated(has_feedback=sound_has_feedback, kind="audio")
        settings = Settings()
        steps = [Step(o.name, o.size, o.fps, o.bitrate_bps, 0) for o in settings.video.renditions]
        encodings = [SoundEncoding(one.mu_ms, one.bitrate_bps) for one in settings.audio.encodings]
        self._allocator = Allocator(steps, encodings)
        self._sound_has_feedback = sound_has_feedback
        self._link = Direction(network.down, seed=1, way="down", start_s=0.0)
        self._link.start_changes(0.0)
        self.now_s = 0.0
        self.size: str | None = "640x480"
        self.states: list[tuple[float, str]] = []
        self.pictures: list[float] = []
        self.sound_ages_ms: list[tuple[float, float]] = []
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._number = 0
        self._packets: dict[int, tuple[float, int, Literal["audio", "video"], int | None]] = {}
        self._marked: deque[int] = deque()
        self._arrived: dict[int, float] = {}
        self._sounds = [0, 0]
        self.allocation: Allocation | None = None
        self._decide(self.control.estimate(0.0), 0.0)
        for first in (self._sound, self._picture, self._feedback, self._report, self._ping):
            self._at(0.0, first)

    @property
    def estimate(self) -> LinkEstimate:
        return self.control.estimate(self.now_s)

    @property
    def width(self) -> int:
        """The width of the picture that is sent, 0 without one."""
        step = self.allocation.step if self.allocation else None
        return 0 if step is None else int(step.size.partition("x")[0])

    @property
    def sound_bps(self) -> int:
        sound = self.allocation.sound if self.allocation else None
        return 0 if sound is None else sound.bitrate_bps

    def run(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while (due_s := min(self._link.next_s(), self._events[0][0])) <= end_s:
            self.now_s = max(self.now_s, due_s)
            for came_s, data in self._link.due(self.now_s):
                self._came(int.from_bytes(data[:8], "big"), came_s)
            while self._events[0][0] <= self.now_s:
                heappop(self._events)[2]()
        self.now_s = end_s

    def _at(self, at_s: float, what: Callable[[], None]) -> None:
        self._number += 1
        heappush(self._events, (at_s, self._number, what))

    def _decide(self, estimate: LinkEstimate, now_s: float) -> None:
        self.states.append((now_s, estimate.state))
        self.allocation = self._allocator.decide(
            estimate,
            size=self.size,
            sound=True,
            sound_encodings=None,
            other_bps=self.control.other_bps,
            now_s=now_s,
        )

    def _sound(self) -> None:
        assert self.allocation is not None
        assert self.allocation.sound is not None
        encoding = self.allocation.sound
        self._sounds[0] += 1
        self._send(encoding.bitrate_bps * encoding.mu_ms // 8000 + HEADERS_BYTES, "audio", None)
        self._at(self.now_s + encoding.mu_ms / 1000, self._sound)

    def _picture(self) -> None:
        step = self.allocation.step if self.allocation else None
        oldest = self._packets[self._marked[0]][0] if self._marked else None
        unreported_s = None if oldest is None else self.now_s - oldest
        if step is None:
            self._at(self.now_s + 0.05, self._picture)
        elif (wait_s := self.control.free_in_s(unreported_s, self.now_s)) > 0:
            self._at(self.now_s + max(wait_s, 0.001), self._picture)
        else:
            size = round(step.bitrate_bps / step.fps / 8)
            train = self.control.plan_train(size, self.now_s)
            count = math.ceil(size / train.payload_bytes)
            self._train(train.number, math.ceil(size / count), count, train.pace_bps)
            self._at(self.now_s + 1 / step.fps, self._picture)

    def _train(self, number: int, size: int, left: int, pace_bps: float) -> None:
        self._send(size + HEADERS_BYTES, "video", number)
        if left > 1:
            after_s = self.now_s + gap_s(size + HEADERS_BYTES, pace_bps)
            self._at(after_s, lambda: self._train(number, size, left - 1, pace_bps))

    def _ping(self) -> None:
        self.control.sent(90, self.now_s, is_media=False, has_feedback=False)
        self.control.round_trip(0.1, self.now_s)
        self._at(self.now_s + 0.5, self._ping)

    def _send(self, size: int, kind: Literal["audio", "video"], train: int | None) -> None:
        self._number += 1
        has_feedback = kind == "video" or self._sound_has_feedback
        self._packets[self._number] = (self.now_s, size, kind, train)
        if has_feedback and self.control.requests_feedback(train, self.now_s):
            self._marked.append(self._number)
        self._link.arrive(self._number.to_bytes(8, "big").ljust(size, b"\0"), self.now_s)
        self.control.sent(size, self.now_s, is_media=True, has_feedback=has_feedback)

    def _came(self, number: int, came_s: float) -> None:
        self._arrived[number] = came_s
        sent_s, _, kind, _ = self._packets[number]
        if kind == "audio":
            self._sounds[1] += 1
            self.sound_ages_ms.append((came_s, (came_s - sent_s) * 1000))
        else:
            self.pictures.append(came_s)

    def _feedback(self) -> None:
        self._at(self.now_s + FEEDBACK_S, self._feedback)
        newest = max((number for number in self._marked if number in self._arrived), default=0)
        told = []
        while self._marked and self._marked[0] <= newest:
            number = self._marked.popleft()
            sent_s, size, kind, train = self._packets[number]
            arrived_s = self._arrived.get(number)
            clock_s = None if arrived_s is None else arrived_s + 4711
            told.append(Delivery(sent_s, clock_s, size, kind, train))
        if told:
            self._at(self.now_s + BACK_S, lambda: self.control.delivered(told, self.now_s))

    def _report(self) -> None:
        self._at(self.now_s + REPORT_S, self._report)
        sent, came = self._sounds
        if sent:
            self._sounds = [0, 0]
            # Packets in flight count in the next report, so the loss is never negative.
            lost = max(1 - came / sent, 0.0)
            self._at(self.now_s + BACK_S, lambda: self.control.lost(lost, self.now_s, kind="audio"))


def network(rate_bps: int, *changes: tuple[float, int], **down: object) -> Profile:
    """Return a link of 20 ms with 500 ms of queue whose rate changes at these times."""
    found = load("lan")
    steps = [Change(at_s=at_s, rate_bps=rate) for at_s, rate in changes]
    keys = {"rate_bps": rate_bps, "queue_ms": 500, "delay_ms": 20, "changes": steps, **down}
    return found.model_copy(update={"down": found.down.model_copy(update=keys)})


@pytest.mark.parametrize("rate_bps", [400_000, 8_000_000, *at_length(1_500_000)])
def test_the_rate_is_that_of_a_browser_that_tells_all(rate_bps: int) -> None:
    """With sound as a known load the same picture is chosen, and the sound is no later."""
    found = []
    for sound_has_feedback in (True, False):
        viewer = Viewer(network(rate_bps), sound_has_feedback=sound_has_feedback)
        viewer.run(12)
        late_ms = sorted(age_ms for at_s, age_ms in viewer.sound_ages_ms if at_s > 8)
        found.append((viewer.width, late_ms[int(0.95 * len(late_ms))]))
        assert viewer.estimate.rate_bps <= 1.1 * rate_bps
    (whole, whole_ms), (untold, untold_ms) = found
    assert untold == whole
    assert untold_ms <= whole_ms + 15


def test_a_fall_of_the_rate_is_answered() -> None:
    """From 5 Mbit/s to 300 kbit/s: after 2 s sound is 150 ms late at most."""
    viewer = Viewer(network(5_000_000, (10, 300_000)), sound_has_feedback=False)
    viewer.run(20)
    assert max(age_ms for at_s, age_ms in viewer.sound_ages_ms if at_s > 12) <= 150
    assert viewer.estimate.rate_bps <= 330_000


def test_lost_sound_is_told_by_reports() -> None:
    """The reports give the share of lost sound, and bursts of at least one packet."""
    loss = load("wifi-bad").down.loss
    viewer = Viewer(network(8_000_000, loss=loss), sound_has_feedback=False)
    viewer.run(20)
    assert viewer.estimate.lost == pytest.approx(0.05, abs=0.03)
    assert viewer.estimate.burst >= 1
    assert viewer.estimate.rate_bps > 1_500_000


def test_jitter_is_known_from_the_pictures() -> None:
    """Where packets vary by up to 30 ms, the first packets of pictures show it."""
    jitter = Jitter(distribution="uniform", ms=15)
    viewer = Viewer(network(8_000_000, jitter=jitter), sound_has_feedback=False)
    viewer.run(12)
    assert 20 <= viewer.estimate.jitter_ms <= 45


def test_sound_alone_is_not_blind() -> None:
    """With the picture off no feedback is awaited; once on, it is full again within 3 s."""
    viewer = Viewer(network(5_000_000), sound_has_feedback=False)
    viewer.run(10)
    viewer.size = None
    off_s = viewer.now_s
    viewer.run(30)
    after = [state for at_s, state in viewer.states if at_s > off_s + 4]
    assert after
    assert set(after) == {"steady"}
    viewer.size = "640x480"
    viewer.run(3)
    assert viewer.width == 640


def test_sound_alone_falls_with_what_is_lost_of_it_and_rises_again() -> None:
    """On 30 kbit/s losses of sound alone choose a smaller encoding, and later the best again."""
    viewer = Viewer(network(500_000, (20, 30_000), (60, 500_000)), sound_has_feedback=False)
    viewer.run(10)
    best_bps = viewer.sound_bps
    viewer.size = None
    viewer.run(50)
    assert viewer.sound_bps < best_bps
    viewer.run(60)
    assert viewer.sound_bps == best_bps


@pytest.mark.parametrize("rate_bps", [22_000, 24_000])
def test_a_picture_that_is_gone_is_tried_again(rate_bps: int) -> None:
    """Where only sound fits, a picture is tried ever more seldom, which seldom delays the sound."""
    viewer = Viewer(network(rate_bps), sound_has_feedback=False)
    viewer.run(120)
    seconds = {int(at_s) for at_s in viewer.pictures if at_s > 10}
    begins = [second for second in seconds if second - 1 not in seconds]
    assert 2 <= len(begins) <= 12
    assert viewer.states[-1][1] != "blind"
    late_ms = sorted(age_ms for at_s, age_ms in viewer.sound_ages_ms if at_s > 20)
    assert late_ms[len(late_ms) // 2] <= 120
