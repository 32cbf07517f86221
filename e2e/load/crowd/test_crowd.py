"""A crowd connects, answers as browsers do, and reports when it cannot."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest
from tests.link.profile import load

from e2e.load.crowd.crowd import gathered
from e2e.load.crowd.modem import put_behind
from e2e.load.crowd.sample import Offering
from e2e.load.servers import SIDES, WAX, serving
from e2e.measure.errors import MeasureError

VIEWERS = 3
WATCHED_S = 3.0


@pytest.mark.timeout(120)
@pytest.mark.parametrize("side", SIDES)
async def test_a_crowd_sees_hears_and_answers(side: str) -> None:
    """Each gets frames and sound; from each, ours gets transport-wide feedback and reports."""
    async with serving(side) as server, gathered(server.offering) as crowd:
        await crowd.hold(VIEWERS)
        await asyncio.sleep(1.0)
        first = await crowd.count()
        await asyncio.sleep(WATCHED_S)
        last = await crowd.count()
        viewers = (await server.status())["viewers"] if side == WAX else []
        await crowd.hold(1)
        await crowd.cycle(1)
        assert len((await crowd.count()).viewers) == 1
    for before, after in zip(first.viewers, last.viewers, strict=True):
        assert after.video.frames > before.video.frames
        assert after.audio.packets > before.audio.packets
        gives_feedback = after.answers.feedbacks > before.answers.feedbacks
        assert gives_feedback == (side == WAX)
    for viewer in viewers:
        assert viewer["report"]["sound"]["age_ms"] > 0
        assert viewer["report"]["picture"]["rate_hz"] is not None


async def test_a_crowd_that_cannot_be_is_one_sentence() -> None:
    """If nobody answers, the near end says so, and the far end has ended."""
    with pytest.raises(MeasureError, match=r"127\.0\.0\.1:9"):
        async with gathered(Offering(url="http://127.0.0.1:9", how="wax")) as crowd:
            await crowd.hold(1)


async def test_a_line_of_ones_own_keeps_order_and_addresses() -> None:
    """Datagrams come out unchanged and in order, with their addresses, until it is closed."""
    come: asyncio.Queue[tuple[bytes, object]] = asyncio.Queue()
    closed = list[bool]()

    def got(data: bytes, address: object) -> None:
        come.put_nowait((data, address))

    transport = SimpleNamespace(sendto=got, is_closing=lambda: bool(closed))
    protocol = SimpleNamespace(transport=transport, datagram_received=got)
    put_behind(protocol, seed=1, profile=load("lan"))
    sent = [(bytes([number]) * number, ("10.0.0.1", number % 3)) for number in range(1, 20)]
    for data, address in sent:
        protocol.datagram_received(data, address)
    assert [await come.get() for _ in sent] == sent
    protocol.datagram_received(b"late", None)
    closed.append(True)
    await asyncio.sleep(0.01)
    assert come.empty()
