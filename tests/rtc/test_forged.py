"""Forged datagrams with a viewer's address and port, from somebody without the keys."""

from __future__ import annotations

import asyncio
from struct import pack
from typing import TYPE_CHECKING, Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.real_link import Link, opened

from wax.rtc import private
from wax.rtc.datagram import MAX_BYTES, is_plausible
from wax.rtc.one_port.lite_connection import LiteConnection

if TYPE_CHECKING:
    from collections.abc import Callable

    import aioice.ice
    from tests.rtc.networks import Mode

MODES: Final = ("one-port", "full-ice")


def _record(kind: int, body: bytes, *, epoch: int = 0, number: int = 9) -> bytes:
    return pack("!BHHHLH", kind, 0xFEFD, epoch, 0, number, len(body)) + body


def _handshake(kind: int, body: bytes) -> bytes:
    whole = len(body).to_bytes(3)
    return _record(22, bytes((kind,)) + whole + bytes(2) + bytes(3) + whole + body)


RANDOM: Final = bytes(range(32))
BEFORE_KEYS: Final = {
    "RTP of 1501 bytes": b"\x80\x60" + bytes(1499),
    "RTCP of 1501 bytes": b"\x80\xc9" + bytes(1499),
    "RTP of 9000 bytes": b"\x80\x60" + bytes(8998),
    "DTLS of 65,000 bytes": _record(23, bytes(64_987), epoch=1),
    "RTP that is cut off": b"\x80\x60" + bytes(9),
    "RTCP that is cut off": b"\x80\xc9\x00\x01",
    "RTP with a wrong tag": b"\x80\x60" + bytes(100),
    "RTCP with a wrong tag": b"\x81\xc9\x00\x07" + bytes(60),
    "RTP that announces extensions": b"\xbf\x60" + b"\xff" * 60,
    "close_notify": _record(21, b"\x01\x00"),
    "a fatal alert": _record(21, b"\x02\x28"),
    "an alert behind data": _record(23, b"x" * 40, epoch=1) + _record(21, b"\x02\x28"),
    "an empty record": _record(22, b""),
    "an empty alert": _record(21, b""),
    "a record that is cut off": _record(23, b"x" * 40, epoch=1)[:-1],
    "half a header": b"\x16\xfe\xfd\x00",
    "one byte": b"\x16",
    "two bytes": b"\x80\xc9",
    "nothing": b"",
    "another protocol": b"GET / HTTP/1.1\r\n\r\n",
}
AFTER_KEYS: Final = {
    "an alert with a key's number": _record(21, b"\x02\x28", epoch=1),
    "an encrypted alert": _record(21, b"\x02\x28" * 20, epoch=1),
    "data with no tag": _record(23, b"x" * 60, epoch=1, number=10**6),
    "data of a later epoch": _record(23, b"x" * 60, epoch=2),
    "ChangeCipherSpec": _record(20, b"\x01"),
    "ClientHello": _handshake(
        1, b"\xfe\xfd" + RANDOM + b"\x00\x00" + b"\x00\x02\xc0\x2b" + b"\x01\x00"
    ),
    "ServerHello": _handshake(2, b"\xfe\xfd" + RANDOM + b"\x00" + b"\xc0\x2b\x00"),
    "HelloVerifyRequest": _handshake(3, b"\xfe\xff\x20" + RANDOM),
    "HelloRequest": _handshake(0, b""),
    "Finished": _handshake(20, bytes(12)),
    "a short header of DTLS 1.3": b"\x2f\x00\x00" + bytes(40),
}


def _hand_in(link: Link) -> Callable[[bytes], None]:
    """Return the function that receives each datagram on this viewer's path."""
    connection: Any = link.ours.transport.transport._connection
    if isinstance(connection, LiteConnection):
        path = connection._agent.selected
        assert path is not None
        return lambda data: connection.handle_datagram(data, path)
    return lambda data: connection.data_received(data, 1)


async def _assert_connected(link: Link) -> None:
    """Assert that it is still connected and heard."""
    assert await link.answers(f"still here {len(link.events.seen)}")
    assert link.peer.is_alive
    assert link.peer._pc.connectionState == "connected"
    assert link.ours.transport.state == "connected"


@pytest.mark.parametrize("mode", MODES)
async def test_forged_datagrams_change_nothing(mode: Mode) -> None:
    """Forged datagrams of any kind and length, alone or together, change nothing for the viewer."""
    async with opened(mode) as link:
        forged = tuple((BEFORE_KEYS | AFTER_KEYS).values())
        told: list[bytes] = []
        handle = link.ours.transport._handle_rtcp_data

        async def noted(data: bytes) -> None:
            told.append(data)
            await handle(data)

        link.ours.transport._handle_rtcp_data = noted  # type: ignore[method-assign]
        hand_in = _hand_in(link)
        for data in forged:
            hand_in(data)
            await asyncio.sleep(0)
        await _assert_connected(link)
        # The browser's own reports arrive meanwhile; a forged one, without a tag, would be shorter.
        assert not [one for one in told if any(data.startswith(one) for data in forged)]


@pytest.mark.parametrize("mode", MODES)
async def test_forged_datagrams_do_not_break_the_handshake(
    mode: Mode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A handshake completes although each of its datagrams is preceded by one of every kind."""
    lite, full = LiteConnection.handle_datagram, private._data_received
    forged = 0

    def lite_datagram(self: LiteConnection, data: bytes, path: Any) -> None:
        nonlocal forged
        for one in BEFORE_KEYS.values():
            forged += 1
            lite(self, one, path)
        lite(self, data, path)

    def full_datagram(self: aioice.ice.Connection, data: bytes, component: int) -> None:
        nonlocal forged
        for one in BEFORE_KEYS.values():
            forged += 1
            full(self, one, component)
        full(self, data, component)

    monkeypatch.setattr(LiteConnection, "handle_datagram", lite_datagram)
    monkeypatch.setattr(private, "_data_received", full_datagram)  # `install` puts it in place
    async with opened(mode) as link:
        await _assert_connected(link)
    assert forged > 3 * len(BEFORE_KEYS)


@pytest.mark.parametrize("mode", MODES)
async def test_replayed_datagrams_do_nothing(mode: Mode, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replaying all that a browser has sent, in order or reversed, does nothing."""
    heard: list[bytes] = []
    take = private._Guard.__call__

    async def overheard(self: private._Guard) -> bytes:
        data = await take(self)
        heard.append(data)
        return data

    monkeypatch.setattr(private._Guard, "__call__", overheard)
    async with opened(mode) as link:
        await link.answers("once")
        await asyncio.sleep(0.5)  # lets it send reports, too
        hand_in = _hand_in(link)
        captured = list(heard)
        assert {data[0] for data in captured} >= {22, 23}
        for data in [*captured, *reversed(captured)]:
            hand_in(data)
            await asyncio.sleep(0)
        await _assert_connected(link)  # its messages arrive behind all the others
        again = [text for what, text in link.events.seen if what == "received state"]
        assert again.count("once") == 1


@pytest.mark.parametrize("mode", MODES)
async def test_a_library_error_on_forged_data_ends_nobody(
    mode: Mode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a library raises, the next datagram is handled."""
    async with opened(mode) as link:
        take = link.ours.transport._rx_srtp

        class Stumbling:
            def unprotect(self, data: bytes) -> bytes:
                raise RuntimeError("a defect")

            unprotect_rtcp = unprotect

        monkeypatch.setattr(link.ours.transport, "_rx_srtp", Stumbling())
        for _ in range(3):
            _hand_in(link)(BEFORE_KEYS["RTP with a wrong tag"])
        await asyncio.sleep(0.05)
        monkeypatch.setattr(link.ours.transport, "_rx_srtp", take)
        await _assert_connected(link)


@pytest.mark.parametrize("name", BEFORE_KEYS)
def test_implausible_datagrams_are_dropped_first(name: str) -> None:
    """Datagrams that are recognisably forged do not reach the libraries."""
    assert is_plausible(BEFORE_KEYS[name]) == (
        name in ("RTP with a wrong tag", "RTCP with a wrong tag", "RTP that announces extensions")
    )


@given(st.binary(max_size=2000), st.sampled_from([20, 21, 22, 23, 25, 26]), st.integers(1, 3))
def test_whole_records_of_any_kind_pass(body: bytes, kind: int, many: int) -> None:
    """DTLS records of any kind pass if they fit one datagram and none is a plaintext alert."""
    record = _record(kind, body, epoch=0 if kind == 22 else 1)
    whole = record * many
    assert is_plausible(whole) == (len(body) > 0 and len(whole) <= MAX_BYTES)
    assert not is_plausible(whole + b"\x16")


@given(st.binary(max_size=60))
def test_nothing_is_raised(data: bytes) -> None:
    """Any bytes are either plausible or not; nothing is raised."""
    for start in (b"", b"\x16\xfe", b"\x17\xfe\xfd\x00\x01", b"\x80", b"\x80\xc9"):
        is_plausible(start + data)
