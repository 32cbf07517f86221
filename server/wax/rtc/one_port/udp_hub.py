"""The sockets of the one port: hands each datagram to its peer.

A check names its peer (STUN USERNAME, RFC 8445 7.1.2). Other datagrams are assigned by their path,
once a peer has verified it; the path then has its own receive queue where the system can do that.
Other paths are dropped without an answer, except for encrypted DTLS: a browser with a new address
may have sent it, so silent peers try to decrypt it.
"""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import struct
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, cast

import structlog
from aioice.stun import COOKIE, Message, parse_message

from wax.edge.binding import advice
from wax.errors import StartError, reason_of
from wax.rate_limits import TokenBucket
from wax.rtc.egress import runs
from wax.rtc.one_port.lite_agent import Path
from wax.rtc.one_port.viewer_socket import CAN_CONNECT, ViewerSocket

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.edge.turnstile import Meter

_LOG = structlog.get_logger(__name__)

_COOKIE: Final = COOKIE.to_bytes(4, "big")
_MAX_STUN_BYTES: Final = 548
"""A check has about a hundred."""
_BUFFER_BYTES: Final = 1 << 20
_MAX_WAITING_BYTES: Final = 1 << 18
"""Send backlog of a socket that the system does not drain; datagrams behind it would be stale."""
_BATCH_S: Final = 0.001
"""Datagrams are read for this long at once. asyncio alone reads one per pass of its loop, so a
flood would delay everybody behind it; a junk datagram costs a few microseconds."""
_LONGEST_BYTES: Final = 65_536
_STUN_HEADER_BYTES: Final = 20
_USERNAME: Final = 0x0006
_APPLICATION_DATA: Final = 23
_DTLS_HEADER_BYTES: Final = 13
_STRAYS_HZ: Final = 100.0
"""Rate limit for trying strangers' datagrams with peers' keys, some 50 µs each."""
_STRAYS_BURST: Final = 200.0
_STRAY_TRIES: Final = 8
"""Peers that try one datagram; a browser that has moved soon sends another."""
_TRIES: Final = 5
"""Attempts at a port that is free on all addresses, if any port will do."""


_CAN_SEGMENT: Final = sys.platform == "linux"
_UDP_SEGMENT: Final = 103
"""The socket option and ancillary data (linux/udp.h) that give the size of each datagram."""
_MOST_SEGMENTS: Final = 64
"""Per call (UDP_MAX_SEGMENTS)."""
_REFUSALS: Final = {errno.EINVAL, errno.EIO, errno.EMSGSIZE, errno.EOPNOTSUPP, errno.ENOPROTOOPT}
"""Errors of a kernel or interface that cannot segment, or of a path that carries no such size."""


class HubPeer(Protocol):
    """A peer of the hub; its methods must not raise."""

    @property
    def meter(self) -> Meter:
        """Charged for the checks addressed to this peer."""
        ...

    @property
    def has_room(self) -> bool:
        """Whether it can take another datagram; if not, it calls `UdpHub.resume` later."""
        ...

    def handle_stun(self, message: Message, path: Path) -> None: ...

    def handle_datagram(self, data: bytes, path: Path) -> None: ...

    @property
    def is_quiet(self) -> bool:
        """Whether its browser's address has fallen silent."""
        ...

    def try_stray(self, data: bytes, path: Path) -> None:
        """Try whether its browser has sent this from a new address."""
        ...

    def lose_path(self, path: Path) -> None:
        """Give up a path that another peer has verified as its own."""
        ...


class _Bound(NamedTuple):
    """A socket, and asyncio's transport that reads from it."""

    transport: asyncio.DatagramTransport
    bound: socket.socket


class UdpHub:
    """One socket for each local address, all with the same port.

    `addresses` returns those of this machine, which may change. Port 0 is any free one.
    """

    def __init__(self, port: int, addresses: Callable[[], list[str]]) -> None:
        self.port = port
        self._is_any = port == 0
        self._find = addresses
        self._next = 0
        self._sockets: dict[int, _Bound] = {}
        self._numbers: dict[str, int] = {}
        self._failed: dict[str, OSError] = {}
        self._opening = asyncio.Lock()
        self._peers: dict[str, HubPeer] = {}
        self._paths: dict[Path, HubPeer] = {}
        self._queues: dict[Path, ViewerSocket] = {}
        self._full: set[Path] = set()
        self._can_connect = CAN_CONNECT
        self._asked: dict[bytes, HubPeer] = {}
        self._strays = TokenBucket(_STRAYS_HZ, _STRAYS_BURST)

    async def open(self) -> None:
        """Bind the port; raises `StartError` if it cannot be bound on any address."""
        for tries_left in reversed(range(_TRIES if self._is_any else 1)):
            await self.rebind()
            if not self._failed or tries_left == 0:
                break
            self.close()
            self.port = 0
            self._failed.clear()
        if not self._numbers:
            raise StartError(self._why_not())
        for address, error in self._failed.items():
            _LOG.warning("an address is not served", address=address, why=reason_of(error))

    async def rebind(self) -> list[str]:
        """Bind new addresses, close those that are gone; returns the addresses served."""
        async with self._opening:
            wanted = self._find()
            for address in self._numbers.keys() - set(wanted):
                number = self._numbers.pop(address)
                self._sockets.pop(number).transport.close()
                for path in [path for path in self._queues if path.socket == number]:
                    self._close_queue(path)
            for address in wanted:
                if address not in self._numbers:
                    await self._bind(address)
            return [address for address in wanted if address in self._numbers]

    async def _bind(self, address: str) -> None:
        number = self._next
        self._next += 1
        try:
            bound = _bound(address, self.port)
        except OSError as error:
            self._failed[address] = error
            return
        transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: _Socket(self, number, bound), sock=bound
        )
        self._failed.pop(address, None)
        self.port = bound.getsockname()[1]
        self._sockets[number] = _Bound(transport, bound)
        self._numbers[address] = number

    def _why_not(self) -> str:
        if not self._failed:
            return (
                "this machine has none of the interfaces in [network] interfaces; correct their"
                " names (`ip address` lists them), or leave the key out to use all"
            )
        why = "; ".join(f"{address}: {reason_of(error)}" for address, error in self._failed.items())
        return (
            f"UDP port {self.port}, which carries picture, sound and commands, cannot be used"
            f" ({why}). {advice(next(iter(self._failed.values())), '--udp-port')}"
        )

    def add(self, username: str, peer: HubPeer) -> None:
        """Route the checks for this user name to a peer."""
        self._peers[username] = peer

    def remove(self, username: str, peer: HubPeer) -> None:
        """Forget a peer and its paths."""
        if self._peers.get(username) is peer:
            del self._peers[username]
        for path in [path for path, one in self._paths.items() if one is peer]:
            self.give_up(path, peer)
        self._asked = {number: one for number, one in self._asked.items() if one is not peer}

    def claim(self, path: Path, peer: HubPeer) -> None:
        """Route the datagrams of a path to a peer, which has verified it.

        Another peer's claim ends: the path's browser now knows this peer's password, and a router
        may have reassigned the port.
        """
        old = self._paths.get(path)
        self._paths[path] = peer
        if old is not None and old is not peer:
            old.lose_path(path)
        self._open_queue(path)

    def give_up(self, path: Path, peer: HubPeer) -> None:
        """End a peer's claim to a path."""
        if self._paths.get(path) is peer:
            del self._paths[path]
            self._close_queue(path)

    def resume(self, peer: HubPeer) -> None:
        """Resume reading for a peer that has room again; cheap if nothing was paused."""
        for path in [path for path in self._full if self._paths.get(path) is peer]:
            self._full.discard(path)
            self._queues[path].resume()

    def _open_queue(self, path: Path) -> None:
        if not self._can_connect or path in self._queues or path.socket not in self._sockets:
            return

        def deliver(data: bytes, host: str, port: int) -> bool:
            self.received(path.socket, data, host, port)
            peer = self._paths.get(path)
            if peer is None or peer.has_room:
                return True
            self._full.add(path)
            return False

        try:
            self._queues[path] = ViewerSocket(path, self._sockets[path.socket].bound, deliver)
        except OSError as error:  # such as too many open files: the path stays in the shared queue
            _LOG.warning("a viewer shares the queue of everybody", why=reason_of(error))

    def expect(self, transaction: bytes, peer: HubPeer) -> None:
        """Route the response to this check to a peer."""
        self._asked[transaction] = peer

    def forget(self, transaction: bytes) -> None:
        """Stop expecting a response to this check."""
        self._asked.pop(transaction, None)

    def send(self, path: Path, data: bytes) -> None:
        """Send a datagram, or drop it if the socket's backlog is full."""
        found = self._sockets.get(path.socket)
        if found is not None and _waiting_bytes(found.transport) < _MAX_WAITING_BYTES:
            found.transport.sendto(data, (path.host, path.port))

    def send_together(
        self, path: Path, datagrams: memoryview, sizes: Sequence[int], *, segmented: bool
    ) -> bool:
        """Send datagrams stored back to back, or drop them if the socket's backlog is full.

        With `segmented`, those of one size leave in one call; returns whether to do so again.
        """
        found = self._sockets.get(path.socket)
        if found is None or (waiting := _waiting_bytes(found.transport)) >= _MAX_WAITING_BYTES:
            return segmented
        if waiting or os.name != "posix":
            _queue(found.transport, datagrams, sizes, path)
            return segmented
        index = at = 0
        for count in runs(sizes, _MOST_SEGMENTS if segmented and _CAN_SEGMENT else 1):
            end = at + sum(sizes[index : index + count])
            try:
                _send(found.bound, datagrams[at:end], sizes[index], path)
            except BlockingIOError:
                _queue(found.transport, datagrams[at:], sizes[index:], path)
                break
            except OSError as error:  # concerns this address only
                if count > 1 and error.errno in _REFUSALS:
                    return self.send_together(path, datagrams[at:], sizes[index:], segmented=False)
            index, at = index + count, end
        return segmented

    def _close_queue(self, path: Path) -> None:
        self._full.discard(path)
        if path in self._queues:
            self._queues.pop(path).close()

    def close(self) -> None:
        """Close every socket; safe to call twice."""
        for path in list(self._queues):
            self._close_queue(path)
        for bound in self._sockets.values():
            bound.transport.close()
        self._sockets.clear()
        self._numbers.clear()

    def received(self, number: int, data: bytes, host: str, port: int) -> None:
        """Handle a datagram that a socket has received."""
        if not data:  # aiortc would end the peer over its missing first byte
            return
        path = Path(number, host, port)
        peer = self._paths.get(path)
        if data[4:8] == _COOKIE and data[0] < 4:
            self._stun(data, path)
        elif peer is not None:
            peer.handle_datagram(data, path)
        elif _is_encrypted(data):
            self._offer_stray(data, path)

    def _offer_stray(self, data: bytes, path: Path) -> None:
        """Let silent peers try a stranger's datagram, within a rate limit."""
        now_s = time.monotonic()
        if not self._strays.take(now_s):
            return
        # Round robin: a peer that has just fallen silent is often one of many that send little.
        for name in [name for name, peer in self._peers.items() if peer.is_quiet][:_STRAY_TRIES]:
            if self._strays.take(now_s):
                self._peers[name] = peer = self._peers.pop(name)
                peer.try_stray(data, path)

    def _stun(self, data: bytes, path: Path) -> None:
        """Hand a check or a response to its peer, which is charged for it; parse no others.

        Only a peer's own browser knows its user name, so a flood from new addresses is charged to
        its sender.
        """
        if len(data) > _MAX_STUN_BYTES:  # first: to walk through 64 KB takes 20 ms
            return
        is_request = not (data[0] & 1 or data[1] & 16)
        peer = self._peers.get(_ufrag(data)) if is_request else self._asked.get(data[8:20])
        if peer is None or not peer.meter.is_open:
            return
        began_s = time.thread_time()
        with suppress(ValueError, struct.error):  # ValueError includes bad UTF-8
            peer.handle_stun(parse_message(data), path)
        peer.meter.charge(began_s)


def _is_encrypted(data: bytes) -> bool:
    """Whether it looks like encrypted DTLS 1.2 application data (RFC 6347, 4.1)."""
    return len(data) > _DTLS_HEADER_BYTES and data[0] == _APPLICATION_DATA and data[3:5] != b"\0\0"


def _ufrag(data: bytes) -> str:
    """Return the ufrag that a check is addressed to (RFC 8445, 7.2.2), empty if it has none."""
    at = _STUN_HEADER_BYTES
    while at + 4 <= len(data):
        kind, size = struct.unpack_from("!HH", data, at)
        if kind == _USERNAME:
            username = data[at + 4 : at + 4 + size]
            return username.partition(b":")[0].decode("ascii", errors="replace")
        at += 4 + size + -size % 4
    return ""


class _Socket(asyncio.DatagramProtocol):
    def __init__(self, hub: UdpHub, number: int, bound: socket.socket) -> None:
        self._hub = hub
        self._number = number
        self._bound = bound

    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        self._deliver(data, address)
        if os.name != "posix":  # on Windows asyncio is reading the next one already
            return
        with suppress(OSError):  # nothing left to read
            ends_s = time.monotonic() + _BATCH_S
            while time.monotonic() < ends_s:
                self._deliver(*self._bound.recvfrom(_LONGEST_BYTES))

    def _deliver(self, data: bytes, address: tuple[str, int]) -> None:
        # An IPv6 address comes with flow and scope.
        self._hub.received(self._number, data, address[0].partition("%")[0], address[1])

    def error_received(self, error: Exception) -> None:
        """Ignore an ICMP message, which concerns one address only."""


def _send(bound: socket.socket, datagrams: memoryview, size: int, path: Path) -> None:
    """Send datagrams of `size` bytes, the last of which may be shorter; raises `OSError`."""
    address = (path.host, path.port)
    if len(datagrams) <= size:
        bound.sendto(datagrams, address)
    else:
        segment = (socket.IPPROTO_UDP, _UDP_SEGMENT, struct.pack("=H", size))
        bound.sendmsg([datagrams], [segment], 0, address)


def _queue(
    transport: asyncio.DatagramTransport, datagrams: memoryview, sizes: Sequence[int], path: Path
) -> None:
    """Queue datagrams behind those that asyncio keeps until the socket has room."""
    at = 0
    for size in sizes:
        transport.sendto(bytes(datagrams[at : at + size]), (path.host, path.port))
        at += size


def _waiting_bytes(transport: asyncio.DatagramTransport) -> int:
    # All of asyncio's datagram transports have it, but their type does not declare it.
    waiting: int = cast("Any", transport).get_write_buffer_size()
    return waiting


def _bound(address: str, port: int) -> socket.socket:
    """Bind a socket; raises `OSError`."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    made = socket.socket(family, socket.SOCK_DGRAM)
    try:
        made.setblocking(False)
        # All viewers share one buffer; the system may allow less.
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            with suppress(OSError):
                made.setsockopt(socket.SOL_SOCKET, option, _BUFFER_BYTES)
        made.bind((address, port))
    except OSError:
        made.close()
        raise
    return made
