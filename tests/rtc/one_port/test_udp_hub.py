"""The one port on real sockets: each datagram reaches its peer, and strangers reach nobody."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import sys
import time
from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import pytest
from aioice.candidate import Candidate
from aioice.stun import Class, Message, Method, parse_message
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.examples import UNTIMED
from tests.rtc.networks import rich_meter
from tests.rtc.steps import counted
from tests.until import async_until

from wax.clock import SystemClock
from wax.edge.turnstile import Meter, Turnstile
from wax.errors import StartError
from wax.rtc.one_port import lite_agent, lite_connection, udp_hub
from wax.rtc.one_port.lite_connection import LiteConnection
from wax.rtc.one_port.udp_hub import UdpHub
from wax.rtc.one_port.viewer_socket import CAN_CONNECT

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence

    from wax.rtc.one_port.lite_agent import Path

HERE: Final = "127.0.0.1"
ELSEWHERE: Final = "127.0.0.2"
SOON_S: Final = 0.1
"""Long enough for a datagram on the loopback interface to arrive."""


def on_any_port(host: str) -> socket.socket:
    made = socket.socket(type=socket.SOCK_DGRAM)
    made.bind((host, 0))
    made.setblocking(False)
    return made


class Browser:
    """The browser's side of a connection, at an address of its own."""

    def __init__(self, hub: UdpHub, peer: LiteConnection, name: str, host: str = HERE) -> None:
        self.peer = peer
        self.name = name
        peer.remote_username, peer.remote_password = name, f"password of {name}"
        self.server = (HERE, hub.port)
        self.socket = on_any_port(host)

    def moves(self, host: str = HERE) -> None:
        """Switch to another port, as given by a router that has forgotten the old one."""
        old, self.socket = self.socket, on_any_port(host)
        old.close()  # after the new one is bound, which might get the same port

    def sends(self, data: bytes) -> None:
        self.socket.sendto(data, self.server)

    async def hears(self, within_s: float = 5.0) -> bytes | None:
        """Return the next datagram, None if there is none in time."""
        try:
            async with asyncio.timeout(within_s):
                return await asyncio.get_running_loop().sock_recv(self.socket, 2048)
        except TimeoutError:
            return None

    def check(self, *, nominates: bool = True) -> bytes:
        request = Message(Method.BINDING, Class.REQUEST)
        request.attributes["USERNAME"] = f"{self.peer.local_username}:{self.name}"
        request.attributes["PRIORITY"] = 1
        if nominates:
            request.attributes["USE-CANDIDATE"] = None
        request.add_message_integrity(self.peer.local_password.encode())
        return bytes(request)

    def answer(self, probe: bytes) -> bytes:
        response = Message(Method.BINDING, Class.RESPONSE, parse_message(probe).transaction_id)
        response.attributes["XOR-MAPPED-ADDRESS"] = self.server
        response.add_message_integrity(f"password of {self.name}".encode())
        return bytes(response)

    async def verifies(self, *, nominates: bool = True) -> None:
        """Check, and answer the check that this triggers."""
        self.sends(self.check(nominates=nominates))
        assert parse_message(await self.hears() or b"").message_class == Class.RESPONSE
        self.sends(self.answer(await self.hears() or b""))
        await async_until(lambda: self.is_verified)
        # On a busy machine the check may have been retransmitted meanwhile.
        assert nothing(self.socket, but_checks=True)

    @property
    def is_verified(self) -> bool:
        port = self.socket.getsockname()[1]
        paths = self.peer._agent._paths.items()
        return any(path.port == port and state.is_verified for path, state in paths)

    async def gets(self, data: bytes) -> bool:
        """Return whether data sent to this browser arrives."""
        await self.peer.send(data)
        return await self.hears() == data


class Rig:
    """A hub with two peers, and their browsers."""

    def __init__(self, hub: UdpHub) -> None:
        self.hub = hub
        clock = SystemClock()
        self.peers = [
            LiteConnection(hub, lambda: ["203.0.113.7"], clock.now_s, rich_meter())
            for _ in range(2)
        ]
        self.ada, self.bob = (
            Browser(hub, peer, name) for peer, name in zip(self.peers, ("ada", "bob"), strict=True)
        )

    async def __aenter__(self) -> Rig:
        for peer in self.peers:
            await peer.gather_candidates()
        return self

    async def __aexit__(self, *_: object) -> None:
        for peer in self.peers:
            await peer.close()
        for browser in (self.ada, self.bob):
            browser.socket.close()
        self.hub.close()
        await asyncio.sleep(0)


@pytest.fixture(params=["a queue for each viewer", "one queue"])
async def rig(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[Rig]:
    if request.param == "one queue":
        monkeypatch.setattr(udp_hub, "CAN_CONNECT", False)
    hub = UdpHub(0, lambda: [HERE])
    await hub.open()
    async with Rig(hub) as made:
        yield made


@contextmanager
def stranger() -> Iterator[socket.socket]:
    with on_any_port(ELSEWHERE) as made:
        yield made


def nothing(at: socket.socket, *, but_checks: bool = False) -> bool:
    """Return whether nothing, or nothing but checks, has arrived at a socket, and drain it."""
    try:
        while at.recv(2048)[:1] < b"\x04" and but_checks:
            pass
    except BlockingIOError:
        return True
    return False


async def test_two_peers_share_the_port(rig: Rig) -> None:
    """Each browser reaches only its own peer, and each peer only its own browser."""
    connecting = [asyncio.create_task(peer.connect()) for peer in rig.peers]
    for browser in (rig.ada, rig.bob):
        await browser.verifies()
        browser.sends(f"from {browser.name}".encode())
    await asyncio.gather(*connecting)
    assert await rig.peers[0].recv() == b"from ada"
    assert await rig.peers[1].recv() == b"from bob"
    assert await rig.ada.gets(b"to ada")
    assert await rig.bob.gets(b"to bob")
    assert nothing(rig.ada.socket)


async def test_public_and_own_addresses_are_offered(rig: Rig) -> None:
    """Local addresses are offered too, as some routers' public side is unreachable from inside."""
    offered = [(one.host, one.port, one.type) for one in rig.peers[0].local_candidates]
    port = rig.hub.port
    assert offered == [(HERE, port, "host"), ("203.0.113.7", port, "host")]


async def test_a_replayed_check_moves_nothing(rig: Rig) -> None:
    """An eavesdropper who replays a check gets a few short datagrams, and no traffic moves."""
    await rig.ada.verifies()
    with stranger() as other:
        for _ in range(50):
            other.sendto(rig.ada.check(), rig.ada.server)
        await asyncio.sleep(SOON_S)
        assert await rig.ada.gets(b"picture")
        got = 0
        while not nothing(other):
            got += 1
        assert got <= 50 + 9  # an answer each, and our checks
        other.sendto(b"I am ada", rig.ada.server)
    await asyncio.sleep(0.01)
    assert rig.peers[0]._queue.empty()


async def test_another_peers_check_does_not_take_over_an_address(rig: Rig) -> None:
    """Bob's check sent from ada's address gets none of ada's traffic: ada does not answer ours."""
    await rig.ada.verifies()
    rig.ada.sends(rig.bob.check())
    answered, probe = await rig.ada.hears(), await rig.ada.hears()
    assert answered is not None
    assert probe is not None
    rig.ada.sends(rig.ada.answer(probe))  # her password is not bob's
    await asyncio.sleep(0.01)
    rig.ada.sends(b"from ada")
    assert await reads(rig.peers[0]) == b"from ada"
    assert await rig.ada.gets(b"to ada")
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(rig.peers[1].recv(), SOON_S)


async def test_a_reassigned_nat_port_changes_owner(rig: Rig) -> None:
    """An address of ada's that bob verifies is bob's, and ada's peer stops sending there."""
    await rig.ada.verifies()
    bobs, rig.bob.socket = rig.bob.socket, rig.ada.socket
    await rig.bob.verifies()
    rig.bob.sends(b"from bob")
    assert await reads(rig.peers[1]) == b"from bob"
    await rig.peers[0].send(b"to ada")
    assert await rig.bob.gets(b"to bob")
    rig.bob.socket = bobs


async def test_a_browser_that_nominates_a_new_port_is_followed(rig: Rig) -> None:
    """A browser is followed to a new port once it checks and nominates from there."""
    await rig.ada.verifies()
    rig.ada.moves()
    await rig.ada.verifies()
    assert await rig.ada.gets(b"picture")


RECORD: Final = b"\x17\xfe\xfd\x00\x01" + bytes(60)
"""Encrypted DTLS application data."""


@pytest.fixture
def quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Treat any pause of a browser as a possible change of address."""
    monkeypatch.setattr(lite_agent, "_QUIET_S", 0.0)


async def reads(peer: LiteConnection) -> bytes:
    return await asyncio.wait_for(peer.recv(), 5)


@pytest.mark.usefixtures("quiet")
async def test_a_browser_that_sends_from_a_new_address_is_followed(rig: Rig) -> None:
    """Authenticated data from a new address draws a check, whose answer moves traffic there."""
    moves: list[int] = []
    rig.peers[0]._on_moved = lambda: moves.append(1)
    await rig.ada.verifies()
    assert moves == []
    rig.ada.moves()
    rig.ada.sends(RECORD)
    assert await reads(rig.peers[0]) == RECORD
    rig.peers[0].authenticated()
    rig.ada.sends(rig.ada.answer(await rig.ada.hears() or b""))
    await async_until(lambda: rig.ada.is_verified)
    assert await rig.ada.gets(b"picture")
    assert moves == [1]


@pytest.mark.usefixtures("quiet")
async def test_a_browser_back_at_its_old_address_is_followed_at_once(rig: Rig) -> None:
    """At an address verified before, authenticated data alone moves traffic there."""
    await rig.ada.verifies()
    first, rig.ada.socket = rig.ada.socket, socket.socket(type=socket.SOCK_DGRAM)
    rig.ada.moves()
    await rig.ada.verifies()
    assert await rig.ada.gets(b"there")
    rig.ada.socket.close()
    rig.ada.socket = first
    rig.ada.sends(RECORD)
    assert await reads(rig.peers[0]) == RECORD
    rig.peers[0].authenticated()
    assert await rig.ada.gets(b"here again")


@pytest.mark.usefixtures("quiet")
async def test_undecryptable_data_moves_nobody(rig: Rig) -> None:
    """Every silent peer tries an undecryptable datagram, and its sender gets nothing."""
    await rig.ada.verifies()
    await rig.bob.verifies()
    with stranger() as other:
        other.sendto(RECORD, rig.ada.server)
        for peer in rig.peers:
            assert await reads(peer) == RECORD
        rig.ada.sends(b"from ada")
        assert await reads(rig.peers[0]) == b"from ada"
        rig.peers[0].authenticated()  # that datagram, not the stranger's
        await asyncio.sleep(SOON_S)
        assert nothing(other)
    assert await rig.ada.gets(b"picture")


async def test_a_peer_that_is_heard_tries_no_strays(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A peer that hears its browser tries no stranger's datagram; nobody tries a handshake."""
    await rig.ada.verifies()
    with stranger() as other:
        other.sendto(RECORD, rig.ada.server)
        await asyncio.sleep(0.01)
        assert rig.peers[0]._queue.empty()
        monkeypatch.setattr(lite_agent, "_QUIET_S", 0.0)
        for junk in (b"\x16" + RECORD[1:], RECORD[:3] + bytes(60), RECORD[:13], b"\x80" * 60):
            other.sendto(junk, rig.ada.server)
        await asyncio.sleep(0.01)
    assert rig.peers[0]._queue.empty()


@pytest.mark.usefixtures("quiet")
async def test_strays_are_tried_at_a_bounded_rate(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Strangers' datagrams are tried at a bounded rate, and each peer queues one at most."""
    await rig.ada.verifies()
    await rig.bob.verifies()
    monkeypatch.setattr(udp_hub, "_STRAYS_HZ", 0.0)
    tried: list[bytes] = []
    for _ in range(5):
        rig.hub.received(0, RECORD, ELSEWHERE, 4000)
    assert [peer._queue.qsize() for peer in rig.peers] == [1, 1]
    for peer in rig.peers:
        monkeypatch.setattr(peer, "try_stray", lambda data, _path: tried.append(data))
    for number in range(10_000):
        rig.hub.received(0, RECORD, ELSEWHERE, 1000 + number)
    assert 100 < len(tried) <= 200


@pytest.mark.usefixtures("quiet")
async def test_silent_peers_try_strays_in_turn(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Among many silent peers, one whose browser has moved waits for a few datagrams only."""
    await rig.ada.verifies()
    await rig.bob.verifies()
    monkeypatch.setattr(udp_hub, "_STRAY_TRIES", 1)
    for tried in ([1, 0], [1, 1]):
        rig.hub.received(0, RECORD, ELSEWHERE, 4000)
        assert [peer._queue.qsize() for peer in rig.peers] == tried


async def test_candidates_are_not_checked(rig: Rig) -> None:
    """Candidates of strangers in an offer are sent nothing."""
    with stranger() as other:
        host, port = other.getsockname()
        for number in range(100):
            await rig.peers[0].add_remote_candidate(
                Candidate(str(number), 1, "udp", 1, host, port, "host")
            )
        connecting = asyncio.create_task(rig.peers[0].connect())
        await asyncio.sleep(5 * SOON_S)
        assert nothing(other)
        await rig.peers[0].close()
        with pytest.raises(ConnectionError):
            await connecting


async def test_junk_is_dropped_without_an_answer(rig: Rig) -> None:
    """No kind of junk from an unknown address gets an answer."""
    good = rig.ada.check()
    other_password = Message(Method.BINDING, Class.REQUEST)
    other_password.attributes["USERNAME"] = f"{rig.peers[0].local_username}:ada"
    other_password.add_message_integrity(b"guess")
    answer = Message(Method.BINDING, Class.RESPONSE)
    answer.add_message_integrity(b"password of ada")
    with stranger() as other:
        for junk in (
            b"",
            b"\x80\x60" + bytes(1200),  # RTP
            b"\x16\xfe\xff" + os.urandom(200),  # DTLS
            good[:30],
            good[:4] + good[4:8] + bytes(12),
            bytes(other_password),
            bytes(answer),
            good + bytes(1000),
            b"\x00\x01\x00\x08" + good[4:20] + b"\x00\x06\x00\x04\xff\xfe\xfd\xfc",  # bad UTF-8
        ):
            other.sendto(junk, rig.ada.server)
        await asyncio.sleep(SOON_S)
        assert nothing(other)
    await rig.ada.verifies()


@settings(suppress_health_check=[*UNTIMED, HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=600), is_stun=st.booleans(), is_ada=st.booleans())
async def test_no_bytes_raise(rig: Rig, data: bytes, *, is_stun: bool, is_ada: bool) -> None:
    """No bytes raise anything, neither from a stranger nor from a viewer."""
    if is_stun:
        head = rig.ada.check()[:20]
        data = head[:2] + len(data).to_bytes(2, "big") + head[4:] + data
    host, port = rig.ada.socket.getsockname()
    rig.hub.received(0, data, host if is_ada else ELSEWHERE, port)


async def test_an_empty_datagram_ends_nothing(rig: Rig) -> None:
    """After a forged empty datagram, the next one is read as usual."""
    await rig.ada.verifies()
    rig.ada.sends(b"")
    rig.ada.sends(b"from ada")
    assert await reads(rig.peers[0]) == b"from ada"


async def test_a_flood_delays_nobody_else(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """One viewer's flood waits in their own queue, and the overflow is lost."""
    monkeypatch.setattr(lite_connection, "_STEP_S", 0.0)
    monkeypatch.setattr(lite_connection, "_STEP_SHARE", 0.0)
    for peer in rig.peers:  # each datagram uses it up
        monkeypatch.setattr(peer, "_step_s", 0.0)
    read: list[str] = []

    async def reads(peer: LiteConnection) -> None:
        while True:
            read.append((await peer.recv()).decode())

    await rig.ada.verifies()
    await rig.bob.verifies()
    reading = [asyncio.create_task(reads(peer)) for peer in rig.peers]
    await asyncio.sleep(0)
    for _ in range(200):
        rig.ada.sends(b"ada")
    rig.bob.sends(b"bob")
    await async_until(lambda: "bob" in read)
    for task in reading:
        task.cancel()
    await asyncio.wait(reading)
    assert read.index("bob") < 20
    assert read.count("ada") <= 200


@pytest.mark.parametrize(
    ("each_s", "pass_s", "in_a_row"),
    [(0.0001, 0.0, 5), (0.0006, 0.0, 1), (0.0006, 0.05, 9), (0.0006, 0.02, 4)],
)
async def test_datagrams_share_a_pass(
    each_s: float, pass_s: float, in_a_row: int, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A peer gets half a millisecond of a pass, or a tenth of a long one."""
    worked_s, one_pass, start_s = 0.0, 0, time.monotonic()
    monkeypatch.setattr(time, "thread_time", lambda: worked_s)
    monkeypatch.setattr(rig.peers[0], "_now_s", lambda: start_s + one_pass * pass_s)
    await rig.ada.verifies()
    for _ in range(12):
        rig.ada.sends(b"ada")
    await async_until(lambda: rig.peers[0]._queue.qsize() == 12)
    passes = Counter[int]()

    async def reads() -> None:
        nonlocal worked_s
        while True:
            await rig.peers[0].recv()
            worked_s += each_s
            passes[one_pass] += 1

    reading = asyncio.create_task(reads())
    while passes.total() < 12:
        one_pass += 1
        await asyncio.sleep(0)
    reading.cancel()
    assert max(passes.values()) == in_a_row


@pytest.mark.skipif(not CAN_CONNECT, reason="this system has one queue for all")
async def test_unread_datagrams_stay_in_the_peers_own_queue() -> None:
    """An unread flood costs nobody anything, and the others' datagrams arrive."""
    hub = UdpHub(0, lambda: [HERE])
    await hub.open()
    async with Rig(hub) as rig:
        await rig.ada.verifies()
        await rig.bob.verifies()
        for number in range(1000):
            rig.ada.sends(b"%d" % number)
        rig.bob.sends(b"bob")
        assert await reads(rig.peers[1]) == b"bob"
        await async_until(lambda: rig.peers[0]._queue.qsize() >= 16)
        await asyncio.sleep(SOON_S)
        assert rig.peers[0]._queue.qsize() == 16
        for number in range(100):  # and once it reads, it resumes where it was
            assert await reads(rig.peers[0]) == b"%d" % number


async def test_a_shared_queue_keeps_the_newest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A shared queue keeps the newest datagrams: an old command is useless."""
    monkeypatch.setattr(udp_hub, "CAN_CONNECT", False)
    hub = UdpHub(0, lambda: [HERE])
    await hub.open()
    async with Rig(hub) as rig:
        await rig.ada.verifies()
        await rig.bob.verifies()
        for number in range(300):
            rig.ada.sends(b"%d" % number)
        rig.bob.sends(b"behind all of them")
        await reads(rig.peers[1])
        assert await rig.peers[0].recv() == b"172"


async def test_a_forged_icmp_message_ends_nothing(rig: Rig) -> None:
    """After an ICMP error on a connected socket, later datagrams are read."""
    await rig.ada.verifies()
    address = rig.ada.socket.getsockname()
    rig.ada.socket.close()
    await rig.peers[0].send(b"nobody listens there")  # the kernel reports an error
    await asyncio.sleep(0.01)
    rig.ada.socket = socket.socket(type=socket.SOCK_DGRAM)
    rig.ada.socket.setblocking(False)
    rig.ada.socket.bind(address)
    rig.ada.sends(b"from ada")
    assert await reads(rig.peers[0]) == b"from ada"


async def test_a_viewer_without_a_socket_uses_the_shared_one(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If no more files can be opened, datagrams arrive through the shared socket."""

    def refuse(*_: object) -> None:
        raise OSError(errno.EMFILE, "too many open files")

    monkeypatch.setattr(udp_hub, "ViewerSocket", refuse)
    await rig.ada.verifies()
    rig.ada.sends(b"from ada")
    assert await reads(rig.peers[0]) == b"from ada"


class Poor(Meter):
    """A meter that is over budget."""

    def __init__(self) -> None:
        super().__init__(Turnstile(SystemClock()), rich_meter()._guest)

    is_open = False


async def test_a_flood_of_checks_is_charged_to_the_named_peer(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Checks of a peer over budget are not answered on any port; a newcomer connects."""
    await rig.ada.verifies()
    monkeypatch.setattr(rig.peers[0], "meter", Poor())
    rig.ada.sends(rig.ada.check())
    assert await rig.ada.hears(SOON_S) is None
    rig.ada.moves()
    rig.ada.sends(rig.ada.check())
    assert await rig.ada.hears(SOON_S) is None
    await rig.bob.verifies()
    monkeypatch.undo()
    await rig.ada.verifies()


async def test_a_check_of_64_kilobytes_is_not_searched(rig: Rig) -> None:
    """A stranger's longest datagram, full of empty attributes, costs no more than other junk."""
    head = rig.ada.check()[:20]
    with counted() as steps:
        rig.hub.received(0, head + b"\x80\x22\0\0" * 16_000, ELSEWHERE, 9)
    assert steps.count < 5000


async def test_connecting_without_checks_times_out(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Connecting times out without checks, and releases everything it held."""
    monkeypatch.setattr(lite_connection, "_CONNECT_S", 0.05)
    with pytest.raises(ConnectionError):
        await rig.peers[0].connect()
    assert (await rig.peers[0].get_event()) is not None
    rig.ada.sends(rig.ada.check())
    assert await rig.ada.hears(SOON_S) is None
    with pytest.raises(ConnectionError):
        await rig.peers[0].recv()


async def test_a_closed_peer_leaves_nothing_in_the_hub(rig: Rig) -> None:
    """A closed peer leaves no name, paths or pending checks in the hub."""
    await rig.ada.verifies()
    with stranger() as other:
        other.sendto(rig.ada.check(), rig.ada.server)
        await asyncio.sleep(0.01)
    await rig.peers[0].close()
    await rig.peers[0].close()
    await rig.peers[1].close()
    for left in (rig.hub._peers, rig.hub._paths, rig.hub._asked):
        assert not left
    with pytest.raises(ConnectionError):
        await rig.peers[0].send(b"late")


async def test_unanswered_checks_are_forgotten(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks to strangers are forgotten, however many addresses a viewer forges."""
    connecting = asyncio.create_task(rig.peers[0].connect())
    await rig.ada.verifies()
    await connecting
    for number in range(300):
        rig.hub.received(0, rig.ada.check(nominates=False), ELSEWHERE, 1000 + number)
    assert len(rig.hub._asked) <= 8
    assert len(rig.hub._paths) == 1
    assert await rig.ada.gets(b"picture")


async def test_a_port_in_use_is_a_sentence(rig: Rig) -> None:
    """The sentence says which port, why, and what to do."""
    second = UdpHub(rig.hub.port, lambda: [HERE])
    with pytest.raises(StartError, match=rf"UDP port {rig.hub.port}, .* in use.*`ss -.*--udp-port"):
        await second.open()


async def test_missing_interfaces_are_a_sentence() -> None:
    """A misspelt interface name stops the start, instead of leaving an unreachable server."""
    with pytest.raises(StartError, match=r"none of the interfaces in \[network\] interfaces"):
        await UdpHub(0, list).open()


async def test_addresses_come_and_go() -> None:
    """A machine that changes networks is served there without a restart, on the same port."""
    addresses = [HERE]
    hub = UdpHub(0, lambda: list(addresses))
    await hub.open()
    port = hub.port
    addresses[:] = [HERE, ELSEWHERE]
    assert await hub.rebind() == [HERE, ELSEWHERE]
    addresses[:] = [ELSEWHERE, "192.0.2.99"]  # this machine does not have the last one
    assert await hub.rebind() == [ELSEWHERE]
    assert hub.port == port
    await asyncio.sleep(0)
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind((HERE, port))
    hub.close()
    await asyncio.sleep(0)


async def test_ipv6_is_served_too() -> None:
    """IPv6 is served if the machine has it."""
    hub = UdpHub(0, lambda: ["::1"])
    try:
        await hub.open()
    except StartError:
        pytest.skip("this machine has no IPv6")
    peer = LiteConnection(hub, list, SystemClock().now_s, rich_meter())
    await peer.gather_candidates()
    browser = Browser(hub, peer, "ada")
    browser.socket.close()
    browser.server = ("::1", hub.port)
    browser.socket = socket.socket(socket.AF_INET6, socket.SOCK_DGRAM)
    browser.socket.setblocking(False)
    with browser.socket:
        await browser.verifies()
        assert await browser.gets(b"picture")
    await peer.close()
    hub.close()
    await asyncio.sleep(0)


async def test_an_empty_datagram_is_dropped(rig: Rig) -> None:
    """No peer gets an empty datagram, whether it is its browser's or forged."""
    await rig.ada.verifies()
    rig.ada.sends(b"")
    rig.ada.sends(b"from ada")
    async with asyncio.timeout(5):
        assert await rig.ada.peer.recv() == b"from ada"


def together(pieces: Sequence[bytes]) -> tuple[memoryview, list[int]]:
    return memoryview(b"".join(pieces)), [len(piece) for piece in pieces]


PICTURE: Final = (b"a" * 900, b"b" * 900, b"c" * 900, b"d" * 899, b"e" * 20)


async def test_datagrams_sent_in_one_call_arrive_separately(rig: Rig) -> None:
    """Datagrams sent in one call arrive as the same datagrams, in order."""
    await rig.ada.verifies()
    rig.ada.peer.send_together(*together(PICTURE))
    assert [await rig.ada.hears() for _ in PICTURE] == list(PICTURE)
    assert nothing(rig.bob.socket)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux segments datagrams")
@pytest.mark.parametrize("refusal", [errno.EIO, errno.EINVAL, errno.EMSGSIZE])
async def test_segmentation_is_not_retried_where_it_is_refused(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, refusal: int
) -> None:
    """If a tunnel or an old kernel cannot segment, this viewer's datagrams leave one by one."""
    asked: list[int] = []

    def refuse(_bound: socket.socket, datagrams: memoryview, size: int, path: Path) -> None:
        if len(datagrams) > size:
            asked.append(size)
            raise OSError(refusal, "no")
        send(_bound, datagrams, size, path)

    send = udp_hub._send
    await rig.ada.verifies()
    await rig.bob.verifies()
    monkeypatch.setattr(udp_hub, "_send", refuse)
    for _ in range(3):
        rig.ada.peer.send_together(*together(PICTURE))
        assert [await rig.ada.hears() for _ in PICTURE] == list(PICTURE)
    assert asked == [900]
    monkeypatch.undo()
    rig.bob.peer.send_together(*together(PICTURE))
    assert [await rig.bob.hears() for _ in PICTURE] == list(PICTURE)


async def test_a_full_socket_keeps_the_order(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Datagrams refused by a full socket are sent once it has room, and nothing overtakes them."""

    def full(*_: object) -> None:
        raise BlockingIOError

    await rig.ada.verifies()
    with monkeypatch.context() as patched:
        patched.setattr(udp_hub, "_send", full)
        rig.ada.peer.send_together(*together(PICTURE))
    assert [await rig.ada.hears() for _ in PICTURE] == list(PICTURE)


async def test_an_unreachable_address_affects_nobody_else(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lost route affects that viewer only, and segments are tried again when it is back."""

    def unreachable(*_: object) -> None:
        raise OSError(errno.ENETUNREACH, "gone")

    await rig.ada.verifies()
    with monkeypatch.context() as patched:
        patched.setattr(udp_hub, "_send", unreachable)
        rig.ada.peer.send_together(*together(PICTURE))
    assert rig.ada.peer._may_segment
    rig.ada.peer.send_together(*together(PICTURE))
    assert [await rig.ada.hears() for _ in PICTURE] == list(PICTURE)


async def test_a_closed_connection_sends_nothing(rig: Rig) -> None:
    """Sending on a closed connection raises `ConnectionError`."""
    await rig.ada.verifies()
    await rig.ada.peer.close()
    with pytest.raises(ConnectionError):
        rig.ada.peer.send_together(*together(PICTURE))
    assert nothing(rig.ada.socket)
