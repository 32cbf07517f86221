"""Messages that no page of ours would send, while somebody drives."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness.robot import pose, turn_by_key
from wax.client import Client

if TYPE_CHECKING:
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

GO: Final = {
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


def row(message: dict[str, object]) -> str:
    """Return a message in the drive channel's form."""
    return json.dumps(list(message.values()))


def bad_messages(turn: int, now_ms: float) -> list[str | bytes]:
    """Messages that only a fresh operator may send: malformed, oversized, unknown."""
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
    """Return the sum of the server's counts of refusals."""
    what = ("messages refused", "messages not allowed", "messages over the rate")
    return sum(status["counters"].get(name, 0) for name in (*what, "requests refused"))


@pytest.mark.timeout(90)
async def test_bad_messages_are_counted_and_harmless(server: Server, driver: Viewer) -> None:
    """On no channel do they close the peer, move the robot or end somebody's turn."""
    for channel in ("drive", "state"):
        async with Client(server.url) as stranger:
            assert await stranger.pongs(10.0)
            before, start = await server.status(), await pose(server)
            messages = bad_messages(before["turn"]["number"], stranger.server_ms())
            for message in messages:
                getattr(stranger, channel).send(message)
                await asyncio.sleep(0.02)
            least = refused(before) + len(messages) - 3
            await server.until(
                lambda told: refused(told) >= least,  # noqa: B023  # it ends in this round
                "nearly all are counted",
            )
            assert await stranger.pongs(10.0), "the peer no longer answers"
            assert stranger.peer.connectionState == "connected"
            assert not (await pose(server)).moved(start)
            after = await server.status()
            assert "messages failed" not in after["counters"]
            assert after["turn"]["operator"] == before["turn"]["operator"]
            assert after["turn"]["number"] == before["turn"]["number"]
    async with Client(server.url) as stranger:
        for seq in range(2000):
            stranger.drive.send(row(GO | {"seq": seq}))
        await turn_by_key(server, driver)
        await driver.page.keyboard.up("ArrowLeft")
    assert "Traceback" not in server.log
