"""What no page of ours would send."""

from __future__ import annotations

import asyncio
import itertools
import json
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio
from aiortc.rtcsctptransport import DataChunk

from e2e.harness import toml
from e2e.harness.robot import pose, stands_still, turn_by_key
from e2e.harness.wait import eventually
from wax.client import Client, Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

CLIENT = "0a0a0a0a-0000-4000-8000-0a0a0a0a0a0a"


def row(message: dict[str, object]) -> str:
    """Return a message as the drive channel carries it."""
    return json.dumps(list(message.values()))


def offer(sdp: object, **more: object) -> bytes:
    return json.dumps({"sdp": sdp, "client": CLIENT, **more}).encode()


OFFERS = {
    "empty": b"",
    "no JSON": b"v=0\r\n",
    "no UTF-8": b"\xff\xfe{}",
    "a list": b"[1, 2]",
    "no sdp": json.dumps({"client": CLIENT}).encode(),
    "sdp is a number": offer(7),
    "unknown field": offer("v=0\r\n", admin=True),
    "sdp is no sdp": offer("hello"),
    "sdp without sections": offer("v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"),
    "sdp with broken sections": offer(
        "v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"
        "m=audio x y z\r\nm=video 9 UDP/TLS/RTP/SAVPF 96\r\nm=application 9 a b\r\n"
    ),
    "takes no messages": offer(
        "v=0\r\n"
        "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\nm=video 9 UDP/TLS/RTP/SAVPF 96\r\n"
        "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\na=max-message-size:560\r\n"
    ),
    "client is a path": json.dumps({"sdp": "v=0\r\n", "client": "../../etc/passwd"}).encode(),
    "deep": b'{"sdp":' + b"[" * 5000 + b"]" * 5000 + b"}",
}

GO = {
    "type": "drive",
    "seq": 1,
    "turn": 0,
    "sent_server_ms": 0.0,
    "linear": 1.0,
    "angular": 1.0,
    "held": True,
    "speed": "fast",
    "seen_server_ms": None,
    "axes": {},
    "beat": None,
}


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("bad-input"), settings) as running:
        yield running


def is_a_sentence(answer: str) -> bool:
    text = json.loads(answer)["error"]
    return isinstance(text, str) and len(text) > 10 and "Traceback" not in text


@pytest.mark.parametrize("body", OFFERS.values(), ids=OFFERS.keys())
async def test_a_bad_offer_is_refused_with_a_sentence(server: Server, body: bytes) -> None:
    """An invalid offer gets a 4xx and one sentence as JSON."""
    code, answer = await server.post("/api/offer", body, "application/json")
    assert 400 <= code < 500, answer
    assert is_a_sentence(answer)


async def test_offers_that_multiply_work_do_not_delay_the_robot(server: Server) -> None:
    """Five a second, each with 500 codecs and 700 feedbacks for all, leave the loop its time."""
    codecs = "a=rtpmap:96 VP8/90000\r\n" * 500 + "a=rtcp-fb:* nack\r\n" * 700
    costly = (
        "v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"
        "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\nm=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n"
        f"m=video 9 UDP/TLS/RTP/SAVPF 96\r\n{codecs}"
    )

    async def late() -> int:
        return int((await server.status())["counters"].get("control.late", 0))

    before = await late()
    for _ in range(10):
        code, answer = await server.post("/api/offer", offer(costly), "application/json")
        assert 400 <= code < 500, answer
        await asyncio.sleep(0.2)
    assert await late() - before < 5, "one of two offers made the loop late"


async def test_an_oversized_offer_is_refused(server: Server) -> None:
    """A body of a megabyte is refused with a sentence and not read into memory as a whole."""
    code, answer = await server.post("/api/offer", offer("v=0\r\n" * 200_000), "application/json")
    assert code in (400, 413), answer
    assert is_a_sentence(answer)


async def test_an_unknown_address_is_a_404(server: Server) -> None:
    """Addresses that are not there, or climb out of the page's folder, are a 404 or 403."""
    for path in ("/nothing", "/api/nothing", "/..%2f..%2fconfig.py", "/assets/../../app.py"):
        code, _ = await server.get(path)
        assert code in (403, 404), path


def bad_messages(turn: int, now_ms: float) -> list[str | bytes]:
    """Such as only the operator may send, while they are fresh; malformed, oversized, unknown."""
    return [
        row(GO | {"turn": turn, "sent_server_ms": now_ms, "seq": 2**50}),
        row(GO | {"turn": turn + 1, "sent_server_ms": now_ms}),
        json.dumps(GO | {"turn": turn, "sent_server_ms": now_ms}),
        "",
        "no JSON",
        b"\x00\xff\xfe",
        "[]",
        "null",
        "{}",
        '{"type": "shutdown"}',
        '{"type": "drive"}',
        '["drive"]',
        "{" * 300,
        "[" * 500,
        "x" * 5000,
        "x" * 60_000,
        row(GO | {"turn": -1}),
        row(GO | {"turn": 2**60}),
        row(GO | {"linear": 1e308}),
        row(GO | {"linear": float("nan")}),
        row(GO | {"linear": "1"}),
        row(GO | {"extra": 1}),
        row(GO | {"axes": {str(n): 1.0 for n in range(9)}}),
        json.dumps({"type": "want", "sound": True, "picture": True, "size": "9x9", "policy": None}),
        json.dumps({"type": "name", "name": "n" * 1000}),
        json.dumps({"type": "leave"}),
        json.dumps({"type": "join", "as": "operator"}),
        '["ping", 1]',
    ]


def refused(status: dict[str, Any]) -> int:
    """Sum of the server's counts of what it refused."""
    return sum(count for name, count in status["counters"].items() if isinstance(count, int))


@pytest.mark.timeout(90)
@pytest.mark.parametrize("channel", ["drive", "state"])
async def test_bad_messages_are_counted_and_harmless(
    server: Server, open_viewer: OpenViewer, channel: str
) -> None:
    """No message closes the peer, moves the robot or ends somebody's turn; each is counted."""
    operator = await open_viewer(server)
    await operator.join()
    await operator.drives()
    async with Client(server.url) as stranger:
        assert await stranger.pongs()
        before, start = await server.status(), await pose(server)
        messages = bad_messages(before["turn"]["number"], stranger.server_ms())
        for message in messages:
            getattr(stranger, channel).send(message)
            await asyncio.sleep(0.02)

        async def counted() -> bool:
            return refused(await server.status()) - refused(before) >= len(messages) - 3

        await eventually(counted, "nearly all are counted", within_s=3)
        assert await stranger.pongs(5.0), "the peer no longer answers"
        assert stranger.peer.connectionState == "connected"
        assert not (await pose(server)).moved(start)
        after = await server.status()
        assert after["turn"]["operator"] == before["turn"]["operator"]
        assert after["turn"]["number"] == before["turn"]["number"]
    await turn_by_key(server, operator)
    await operator.page.keyboard.up("ArrowLeft")
    assert "Traceback" not in server.log


@pytest.mark.timeout(60)
async def test_commands_of_an_old_turn_or_age_move_nothing(server: Server) -> None:
    """Even the operator's commands are refused with an old turn's number or an old time."""
    async with Operator(server.url) as driver:
        driver.is_silent = True
        await driver.join()
        turn = driver.turn
        assert await driver.pongs()
        sequence = itertools.count(1)

        async def send(*, turn: int, late_ms: float = 0, **more: object) -> None:
            now_ms = driver.server_ms()
            stamp: dict[str, object] = {
                "turn": turn,
                "sent_server_ms": now_ms - late_ms,
                "seen_server_ms": now_ms,
            }
            stamp |= {"seq": next(sequence), "beat": driver.beat}
            driver.drive.send(row(GO | stamp | more))
            await asyncio.sleep(0.02)

        await send(turn=turn, linear=0.0, angular=0.0, held=False)
        start = await pose(server)
        for _ in range(20):
            await send(turn=turn)
        assert (await pose(server)).moved(start), "good commands move nothing either"
        assert await stands_still(server)

        await send(turn=turn, linear=0.0, angular=0.0, held=False)
        start = await pose(server)
        for _ in range(30):
            await send(turn=turn - 1)
            await send(turn=turn + 1)
            await send(turn=turn, late_ms=2000)
            await send(turn=turn, late_ms=-2000)
        assert not (await pose(server)).moved(start)
        driver.state.send(json.dumps({"type": "leave"}))


async def test_a_message_that_never_ends_ends_only_its_sender(server: Server) -> None:
    """A stranger's fragments close the stranger's peer, and another page is answered."""
    async with Client(server.url) as stranger, Client(server.url) as other:
        sctp = stranger.peer.sctp
        assert sctp is not None
        for number in range(200):
            chunk = DataChunk(flags=0 if number else 2)
            chunk.tsn = (sctp._local_tsn + number) % 2**32
            chunk.stream_id, chunk.protocol, chunk.user_data = stranger.state.id, 51, b"x"
            await sctp._send_chunk(chunk)

        async def ended() -> bool:
            return stranger.state.readyState == "closed"

        await eventually(ended, "the stranger is closed", within_s=10)
        assert await other.pongs()
        assert other.peer.connectionState == "connected"


@pytest.mark.timeout(60)
async def test_a_flood_does_not_stop_the_others(server: Server, open_viewer: OpenViewer) -> None:
    """Two thousand messages at once from a stranger leave the operator driving."""
    operator = await open_viewer(server)
    await operator.join()
    await operator.drives()
    async with Client(server.url) as stranger:
        for seq in range(2000):
            stranger.drive.send(row(GO | {"seq": seq}))
        await turn_by_key(server, operator)
        await operator.page.keyboard.up("ArrowLeft")
