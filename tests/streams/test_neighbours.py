"""A browser's reports about its link affect no other viewer."""

from __future__ import annotations

from itertools import pairwise
from random import Random
from typing import TYPE_CHECKING, Any, Final

import pytest
from tests.examples import at_length
from tests.fuzz.mutator import Mutator
from tests.fuzz.target import at_once
from tests.fuzz.targets.network import Transport
from tests.open_boundary import OpenFence
from tests.rtc.browser_feedback import feedback_packet
from tests.streams.live_rig import SIZES, Rig

from wax.config.audio import AudioSettings
from wax.config.sync import SyncSettings
from wax.rtc.transport_tap import TransportTap
from wax.streams.live import LiveService

if TYPE_CHECKING:
    from pydantic import BaseModel

PACKETS: Final = 8
"""The packets that are sent to the liar between two reports."""
STEP_S: Final = 0.05
LIES_S: Final = 5


class Liar:
    """A second viewer of the same pictures, who reports anything."""

    def __init__(self, rig: Rig, seed: int) -> None:
        self.boundary = OpenFence()
        self._rig = rig
        self._random = Random(seed)
        service = LiveService(
            clock=rig.clock,
            video_settings=SIZES,
            audio_settings=AudioSettings(),
            video=rig.video,
            audio=rig.audio,
        )
        self.streams = service.streams(self, SyncSettings())
        lanes = self.streams.make_lanes()
        lanes.congestion.negotiated(has_feedback=True)
        self._tap = TransportTap(lanes.congestion, rig.clock.now_s, lambda: None)
        self._transport = Transport()
        self._tap.attach(self._transport)
        self._number = 0
        self._lies_s = 0.0
        self._lie = "true"
        self.streams.connected()
        self.streams.ready()
        self.streams.want(sound=True, picture=True, size="640x480", policy=None)

    def send(self, message: BaseModel) -> None: ...

    def set_playout_delay(self, least_ms: float) -> bool:
        return True

    def lie(self) -> None:
        """Receive some packets and report about them, in the same way for half a second."""
        now_s = self._rig.clock.now_s()
        for _ in range(PACKETS):
            self._tap.number_packet(1200, now_s, kind="video", train=None)
            self._tap.count_media(1200, now_s, has_feedback=True)
        if now_s >= self._lies_s:
            self._lies_s = now_s + 0.5
            self._lie = self._random.choice(("true", "lost", "late", "early", "noise"))
        report = feedback_packet(self._number, self._arrivals(now_s), self._random)
        if self._lie == "noise":
            report = Mutator(self._random, [report], [], 400).draw()
        at_once(self._transport._handle_rtcp_data(report))
        self._number += PACKETS

    def _arrivals(self, now_s: float) -> list[int | None]:
        ticks = round(now_s * 4000)
        every: dict[str, Any] = {
            "lost": lambda _: None,
            "late": lambda number: ticks + 2000 * number,
            "early": lambda number: ticks - 100 * number,
        }
        return [every.get(self._lie, lambda n: ticks + n)(number) for number in range(PACKETS)]


@pytest.mark.parametrize("seed", [0, *at_length(1)])
async def test_lies_about_one_link_move_nobody_elses_rendition(seed: int) -> None:
    """Others keep the best picture, and are forced to at most a keyframe a second."""
    rig = Rig()
    rig.begin()
    await rig.run(3.0)
    best = SIZES.renditions[0].name
    assert rig.lane.rendition == best
    liar = Liar(rig, seed)
    rig.sizes.clear()
    rig.asked.clear()
    seen = list[float]()
    for _ in range(round(LIES_S / STEP_S)):
        liar.lie()
        seen.append(float(str(liar.streams.status().entry["link_bps"])))
        await rig.run(STEP_S)
        assert rig.lane.rendition == best
    falls = [one - later for one, later in pairwise(seen) if later < 0.8 * one]
    assert falls, "the lies moved nothing at all"
    assert set(rig.sizes) == {best}
    assert len(rig.sizes) > 20 * LIES_S
    assert rig.asked.count(best) <= LIES_S
