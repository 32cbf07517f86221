"""A page's messages: rows, JSON, and HTTP bodies; nobody without the turn moves the robot."""

from __future__ import annotations

import gzip
import json
from typing import TYPE_CHECKING, Any, Final

import pytest
from aiohttp import web
from tests.fuzz.target import Target, at_once
from tests.session.rig import OFFER, FakePeer, Rig, Robot, fake_peers

from wax.control.gate import Command
from wax.driver.interface import Limits, Twist
from wax.errors import ProtocolError, SignallingError
from wax.protocol import messages
from wax.protocol.http_bodies import OfferBody
from wax.rtc.signalling import clean_offer
from wax.session.viewer import command_of
from wax.web import routes

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.rtc.peer import Channel

_SETTLE_S: Final = 0.2
_STEPS: Final = 24_000
"""Mostly for what a room does in `_SETTLE_S`."""
_GZIP: Final = b"\x1f\x8b"
"""The first bytes of a body that claims to be compressed (RFC 1952, 2.3.1)."""


class _Peer(FakePeer):
    def media_time(self, kind: str, rtp: int) -> int:
        return rtp - 1000


def _scene() -> tuple[Rig, FakePeer, FakePeer]:
    """One viewer drives and holds nothing; the other, who is second in the queue, is hostile."""
    with pytest.MonkeyPatch.context() as patch:
        fake_peers(patch, _Peer)
        patch.setattr(Robot, "limits", Limits(1.0, 2.0, ("pan",), lateral_mps=1.0))
        rig = Rig({"turns": {"turn_s": 600.0}})
        driving, hostile = at_once(rig.enter("ada-1111")), at_once(rig.enter("eve-1111"))
    driving.says(type="join")
    hostile.says(type="join")
    rig.wait(_SETTLE_S, driving, hostile)
    rig.drive(driving, 1, linear=0.0)
    rig.wait(0.1, driving, hostile)
    return rig, driving, hostile


def _understood(channel: Channel, data: bytes) -> bool:
    parse: Callable[[bytes], Any] = (
        messages.parse_drive if channel == "drive" else messages.parse_state
    )
    try:
        message = parse(data)
    except ProtocolError:
        return False
    if isinstance(message, messages.Drive):
        command = command_of(message, heard_s=0.0, seen_s=None)
        assert isinstance(command, Command)
        assert -1 <= command.linear <= 1
        assert -1 <= command.angular <= 1
        assert -1 <= command.lateral <= 1
    return True


def _hear(channel: Channel, data: bytes) -> None:
    if not _understood(channel, data):
        return
    rig, driving, hostile = _scene()
    hostile.events.received(channel, data)
    rig.wait(_SETTLE_S, driving, hostile)
    assert not rig.counters.snapshot().get("messages failed"), "handling it failed"
    moved = [told for told in rig.robot.told if isinstance(told, Twist) and not told.is_zero]
    assert not moved, f"the robot was told {moved[0]}"


def _hear_offer(data: bytes) -> None:
    try:
        body = routes.parsed(data, OfferBody, is_packed=data.startswith(_GZIP))
        clean_offer(body.sdp)
    except (ProtocolError, SignallingError, web.HTTPRequestEntityTooLarge):
        pass


def _row(*cells: object) -> bytes:
    return json.dumps(cells, separators=(",", ":")).encode()


def _object(**fields: object) -> bytes:
    return json.dumps(fields, separators=(",", ":")).encode()


_NOW_MS: Final = 1000_300.0
"""The scene's clock, so that a command is fresh."""

DRIVE: Final = Target(
    name="drive",
    what="commands, heartbeats and reports of a page",
    hear=lambda data: _hear("drive", data),
    seeds=(
        _row("drive", 1, 1, _NOW_MS, 1.0, 0.0, True, "fast", _NOW_MS, {}, "x7-_2A"),
        _row("drive", 7, 1, _NOW_MS, -0.5, 0.5, True, "slow", None, {"pan": 0.5}, None),
        _row("drive", 8, 1, _NOW_MS, 0.0, 0.0, True, "fast", _NOW_MS, {}, None, -1.0),
        _row("ping", 3, 12.5, None, None),
        _row("ping", 4, 212.5, 3, 1.5),
        _row("report", [260, 200, None, 0, 1000], [215, 200, 30, 0], 1),
        _row("report", None, None, None),
    ),
    words=(b'"drive"', b'"ping"', b'"report"', b"true", b"null", b"[[", b"{}", b'"fast"', b"\\u"),
    max_bytes=600,
    steps=_STEPS,
    scene=_scene,
)

STATE: Final = Target(
    name="state",
    what="requests of a page",
    hear=lambda data: _hear("state", data),
    seeds=(
        _object(type="name", name="Ada"),
        _object(type="join"),
        _object(type="leave"),
        _object(type="stop"),
        _object(type="release", stop=1, sent_server_ms=_NOW_MS, beat="x7-_2A"),
        _object(type="want", sound=True, picture=True, size="640x480", policy=None),
        _object(type="want", sound=False, picture=False, size="160x120", policy="video-first"),
        _object(type="received", kind="audio", rtp=5000),
    ),
    words=(b'"type"', b'"name"', b'"\\ud800"', "\u202e\u2028é𝕏".encode(), b"true", b"{", b"[["),
    steps=_STEPS,
    scene=_scene,
)

_OFFER: Final = _object(sdp=OFFER.replace("\n", "\r\n"), client="12345678-abcd")

SIGNALLING: Final = Target(
    name="signalling",
    what="bodies of HTTP requests",
    hear=_hear_offer,
    seeds=(_OFFER, gzip.compress(_OFFER, mtime=0)),
    words=(b'"sdp"', b'"client"', b"\\r\\n", b"m=audio 9 x 0", b"a=rtpmap:96 x/9", b"\\ud800"),
)
