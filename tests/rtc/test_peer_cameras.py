"""A real peer on loopback with additional cameras."""

from __future__ import annotations

import asyncio
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Literal

import pytest
from aiortc import RTCPeerConnection
from aiortc.rtp import RtcpPsfbPacket
from tests.rtc.networks import opened_network
from tests.rtc.real_peer import Events, Pictures, agree, peer_of

from wax.streams.interface import CameraLane

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.encode.encoded import EncodedPicture
    from wax.rtc.peer import Peer

Mode = Literal["one-port", "full-ice"]


class Stuck(Pictures):
    """Always has a picture that never leaves."""

    def __init__(self) -> None:
        super().__init__()
        self.is_empty = False

    def pop_next(self) -> EncodedPicture | None:
        return None


class Noticing(Events):
    """Records which camera's keyframe is wanted."""

    def network_changed(self) -> None: ...

    def keyframe_wanted(self, camera: int | None = None) -> None:
        self._note("keyframe", camera)


class Joined:
    """A peer, the lanes of its driving view and cameras, and the browser's side."""

    def __init__(self, peer: Peer, lanes: list[Pictures], events: Noticing, answer: str) -> None:
        self.peer, self.lanes, self.events, self.answer = peer, lanes, events, answer

    async def sent(self, at: int, within_s: float = 10.0) -> bool:
        """Return whether pictures of this lane leave; 0 is the driving view."""
        sender = [self.peer._picture, *self.peer._cameras][at]
        before = sender._packets
        for _ in range(round(within_s / 0.02)):
            if sender._packets > before + 5:
                return True
            await asyncio.sleep(0.02)
        return False


@asynccontextmanager
async def joined(
    *, offered: int, cameras: int, mode: Mode = "one-port", driving_view: Pictures | None = None
) -> AsyncIterator[Joined]:
    """Join with a page that offers so many pictures, at a server with so many cameras."""
    async with opened_network(mode) as opened:
        lanes = [driving_view or Pictures(), *(Pictures() for _ in range(cameras))]
        events, browser = Noticing(), RTCPeerConnection()
        for kind in ("audio", *["video"] * offered):
            browser.addTransceiver(kind, direction="recvonly")
        browser.createDataChannel("drive", ordered=False, maxRetransmits=0)
        browser.createDataChannel("state")
        beside = [CameraLane(lane, "vp8") for lane in lanes[1:]]
        peer = peer_of(opened, events, video=lanes[0], cameras=beside)
        try:
            answer = await agree(peer, browser)
            await events.wait("ready")
            yield Joined(peer, lanes, events, answer)
        finally:
            await peer.close()
            await browser.close()


@pytest.mark.parametrize("mode", ["one-port", "full-ice"])
async def test_every_camera_is_sent_over_the_one_transport(mode: Mode) -> None:
    """The driving view and two cameras leave, each with its own SSRC."""
    async with joined(offered=3, cameras=2, mode=mode) as it:
        assert [await it.sent(at) for at in range(3)] == [True, True, True]
        assert len({one.ssrc for one in (it.peer._picture, *it.peer._cameras)}) == 3
        assert it.peer.is_alive


async def test_a_page_with_room_for_fewer_gets_the_first() -> None:
    """A page with room for one camera of two gets the driving view and the first."""
    async with joined(offered=2, cameras=2) as it:
        assert await it.sent(1)
        assert len(it.peer._cameras) == 1
    async with joined(offered=1, cameras=2) as it:
        assert await it.sent(0)


async def test_room_for_more_stays_empty() -> None:
    """A section without a camera neither sends nor receives, whatever the page offers."""
    async with joined(offered=4, cameras=1) as it:
        assert [await it.sent(at) for at in range(2)] == [True, True]
        ways = re.findall(r"a=(sendonly|recvonly|sendrecv|inactive)", it.answer)
        assert ways == ["sendonly"] * 3 + ["inactive"] * 2


async def test_a_camera_gives_way_to_the_driving_view() -> None:
    """While a driving-view picture waits, no camera's leaves; then cameras continue."""
    stuck = Stuck()
    async with joined(offered=2, cameras=1, driving_view=stuck) as it:
        assert not await it.sent(1, within_s=0.5)
        stuck.is_empty = True
        assert await it.sent(1)


async def test_a_keyframe_request_names_its_camera() -> None:
    """A keyframe request names its camera, and none for the driving view."""
    async with joined(offered=3, cameras=2) as it:
        for sender, number in ((it.peer._picture, None), (it.peer._cameras[1], 1)):
            it.events.seen.clear()
            asked = RtcpPsfbPacket(fmt=1, ssrc=0, media_ssrc=sender.ssrc)
            await sender.transport._handle_rtcp_data(bytes(asked))
            assert ("keyframe", number) in it.events.seen


async def test_a_failed_camera_sender_ends_its_own_peer() -> None:
    """A failed camera sender ends its own peer, so that the page reconnects."""
    async with joined(offered=2, cameras=1) as it:
        it.peer._cameras[0]._fail(ValueError("broken"))
        assert not it.peer.is_alive
