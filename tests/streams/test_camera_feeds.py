"""A viewer's other cameras: when they are sent, and what that costs the driving view."""

from __future__ import annotations

from typing import Any

import pytest
from tests.examples import at_length
from tests.streams.live_rig import TOP, Rig
from tests.turned_clock import TurnedClock

from wax.capture.testcard import TestCardVideo
from wax.config.camera import CameraSettings
from wax.encode.rendition import Rendition
from wax.fanout.camera import Camera
from wax.protocol import messages

LARGE, MIDDLE, SMALL = (one.name for one in CameraSettings(name="any").renditions)


def _rig(rate_bps: float = 20e6, cameras: int = 2, **more: Any) -> Rig:
    clock = TurnedClock(100.0)
    made = []
    for number in range(cameras):
        settings = CameraSettings(name=f"camera {number}", source="testcard")
        source = TestCardVideo(settings, clock)
        made.append(Camera(settings, source, clock=clock, blank=lambda picture: picture))
    return Rig(rate_bps=rate_bps, clock=clock, cameras=made, **more)


def _wanted(rig: Rig) -> list[list[str]]:
    return [camera.hub.wanted for camera in rig.cameras]


async def test_nothing_is_encoded_before_a_page_shows_it() -> None:
    """A page that never says what it shows is sent the driving view only."""
    rig = _rig()
    rig.begin()
    await rig.run(2.0)
    assert rig.streams.status().entry["rendition"] == TOP
    assert _wanted(rig) == [[], []]


async def test_one_is_large_and_the_rest_small_and_the_page_is_told() -> None:
    """Each camera is encoded in the size shown, and only while shown."""
    rig = _rig()
    rig.begin()
    rig.streams.select_cameras(large=1, small=True)
    await rig.run(3.0)
    assert _wanted(rig) == [[SMALL], [LARGE]]
    assert rig.all(messages.Served)[-1].cameras == [SMALL, LARGE]
    rig.streams.select_cameras(large=None, small=True)
    await rig.run(1.0)
    assert _wanted(rig) == [[SMALL], [SMALL]]
    rig.streams.select_cameras(large=None, small=False)
    await rig.run(1.0)
    assert _wanted(rig) == [[], []]
    rig.streams.select_cameras(large=0, small=False)
    await rig.run(1.0)
    rig.streams.release()
    assert _wanted(rig) == [[], []]


async def test_a_machine_that_falls_behind_sends_other_cameras_smaller_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The driving view stays as it is, the host is told, and the camera grows again."""
    rig = _rig()
    rig.begin()
    rig.streams.select_cameras(large=1, small=True)
    await rig.run(3.0)
    monkeypatch.setattr(Rendition, "load", property(lambda one: 1.1 * one.wanted))
    for _ in range(4):
        rig.service.relieve(0.0)
        await rig.run(1.0)
    monkeypatch.setattr(Rendition, "load", property(lambda one: 0.1 * one.wanted))
    assert _wanted(rig) == [[SMALL], [MIDDLE]]
    assert rig.streams.status().entry["rendition"] == TOP
    assert [one.code for one in rig.service.limits.problems()] == ["busy.cameras"]
    rig.clock.time_s += 30.0
    rig.service.relieve(0.0)
    await rig.run(6.0)
    assert _wanted(rig) == [[SMALL], [LARGE]]
    assert rig.service.limits.problems() == []


async def test_who_wants_no_picture_is_sent_none() -> None:
    """With the picture off the cameras are off, too."""
    rig = _rig()
    rig.begin()
    rig.streams.select_cameras(large=0, small=True)
    await rig.run(3.0)
    rig.streams.want(sound=True, picture=False, size="640x480", policy=None)
    await rig.run(1.0)
    assert _wanted(rig) == [[], []]


@pytest.mark.parametrize("rate_bps", [1e6, *at_length(50e3, 100e3, 250e3, 5e5, 2e6, 5e6)])
async def test_the_driving_view_is_what_it_is_without_them(rate_bps: float) -> None:
    """At any link rate a large camera costs the driving view no rendition."""
    seen: list[list[str]] = []
    for cameras in (0, 2):
        rig = _rig(rate_bps, cameras)
        rig.begin()
        rig.streams.select_cameras(large=0 if cameras else None, small=True)
        await rig.run(6.0)
        rig.sizes.clear()
        await rig.run(3.0)
        seen.append(list(dict.fromkeys(rig.sizes)))
    alone, beside = seen
    assert beside == alone


async def test_a_modem_carries_no_other_camera() -> None:
    """A link that carries one picture carries the driving view."""
    rig = _rig(50e3)
    rig.begin()
    rig.streams.select_cameras(large=0, small=True)
    await rig.run(6.0)
    assert rig.streams.status().entry["cameras"] == [None, None]


async def test_a_link_that_narrows_loses_them_first() -> None:
    """On a shrinking link the cameras go first, and the driving view keeps what fits."""
    rig = _rig(8e6)
    rig.begin()
    rig.streams.select_cameras(large=0, small=True)
    await rig.run(6.0)
    assert rig.streams.status().entry["cameras"] == [LARGE, SMALL]
    rig.rate_bps = 300e3
    await rig.run(1.0)
    assert rig.streams.status().entry["cameras"] == [None, None]
    assert rig.streams.status().entry["rendition"] is not None


async def test_a_short_upload_goes_to_driving_views() -> None:
    """The robot's upload serves other viewers' driving views before anybody's cameras."""
    rig = _rig(upload_bps=2_000_000)
    rig.begin()
    rig.streams.select_cameras(large=0, small=True)
    await rig.run(6.0)
    assert rig.streams.status().entry["cameras"] != [None, None]
    assert rig.streams.status().entry["rendition"] == TOP


async def test_a_lane_that_lost_its_thread_is_helped() -> None:
    """A camera's lane that dropped pictures requests one keyframe, not one per decision."""
    rig = _rig()
    rig.begin()
    rig.streams.select_cameras(large=0, small=True)
    await rig.run(3.0)
    lane: Any = rig.camera_lanes[0]
    lane._shed()
    lane._cut_layer = 0
    rig.asked.clear()
    await rig.run(3.0)
    assert rig.asked == [LARGE]
    assert not lane.is_cut
