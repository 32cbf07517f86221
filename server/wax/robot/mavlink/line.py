"""A line to the rover: a serial port, or a socket.

pymavlink has connections of its own, but they swallow errors, print to the standard output (which
in the driver process is the pipe to the server), and let two programs listen on one port.
"""

from __future__ import annotations

import datetime
import errno
import socket
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, Protocol

import serial

from wax.errors import reason_of
from wax.robot.mavlink.address import parse
from wax.robot.mavlink.settings import FRAME_BYTES, SIGNATURE_BYTES
from wax.robot.serial.port_line import why_not_open
from wax.sentence import Sentence
from wax.unreachable import Target, why

if TYPE_CHECKING:
    from wax.robot.mavlink.address import Address
    from wax.robot.mavlink.settings import MavlinkSettings

READ_TIMEOUT_S: Final = 0.1
WRITE_TIMEOUT_S: Final = 0.25
CONNECT_TIMEOUT_S: Final = 0.5
MAX_READ_BYTES: Final = 65_536
MAY_WAIT_BYTES: Final = 200
"""The most bytes that may be queued before a stop; a telemetry radio sends them in 35 ms."""

_END_OF_A_TORN_MESSAGE: Final = bytes(max(FRAME_BYTES.values()) + SIGNATURE_BYTES)
"""Zeros as long as the longest message: they complete a truncated one, else are ignored."""


class MavlinkLine(Protocol):
    """An open line. One thread reads, another writes; both raise `OSError` when it is lost."""

    def read(self) -> bytes:
        """Wait a moment for data; empty if none has come."""
        ...

    def answer(self) -> None:
        """Write from now on to the sender of the data read last."""
        ...

    def write(self, data: bytes) -> None: ...

    def stop(self, data: bytes) -> None:
        """Write a stop, ahead of anything still queued."""
        ...

    def close(self) -> None: ...


def open_line(settings: MavlinkSettings) -> MavlinkLine:
    """Open the line; raises `OSError` (`serial.SerialException` is one) or `ValueError`."""
    address = parse(settings.url)
    match address.kind:
        case "serial":
            return _SerialLine(address, settings.baud)
        case "tcp":
            return _TcpLine(address)
        case _:
            return _UdpLine(address)


def why_closed(settings: MavlinkSettings, error: Exception) -> Sentence:
    """Return why the line did not open, and what to do."""
    address = parse(settings.url)
    if address.kind == "serial":
        return why_not_open(settings.url, error, "robot.mavlink.url")
    if getattr(error, "errno", None) == errno.EADDRINUSE:
        return Sentence("mavlink.in_use", {"link": settings.url})
    target = Target(address.kind, address.where, address.port, CONNECT_TIMEOUT_S)
    told = why(target, error, datetime.datetime.now(datetime.UTC), connecting=True)
    return Sentence(
        "mavlink.not_open", {"link": settings.url, "why": told, "seconds": settings.reopen_s}
    )


def why_lost(settings: MavlinkSettings, error: Exception) -> Sentence:
    """Return why the line was lost."""
    reason, seconds = reason_of(error), settings.reopen_s
    if parse(settings.url).kind == "serial":
        return Sentence("port.lost", {"port": settings.url, "why": reason, "seconds": seconds})
    return Sentence("mavlink.lost", {"link": settings.url, "why": reason, "seconds": seconds})


class _SerialLine:
    def __init__(self, address: Address, baud: int) -> None:
        self._port = serial.Serial(
            address.where,
            baud,
            timeout=READ_TIMEOUT_S,
            write_timeout=WRITE_TIMEOUT_S,
            exclusive=True,
        )

    def read(self) -> bytes:
        data: bytes = self._port.read(max(1, min(self._port.in_waiting, MAX_READ_BYTES)))
        return data

    def answer(self) -> None:
        """There is only one at the other end."""

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def stop(self, data: bytes) -> None:
        with suppress(Exception):  # a port that cannot tell is not a lost one
            if self._port.out_waiting > MAY_WAIT_BYTES:
                self._port.reset_output_buffer()
                data = _END_OF_A_TORN_MESSAGE + data
        self._port.write(data)

    def close(self) -> None:
        self._port.close()


class _TcpLine:
    def __init__(self, address: Address) -> None:
        self._socket = socket.create_connection((address.where, address.port), CONNECT_TIMEOUT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(READ_TIMEOUT_S)

    def read(self) -> bytes:
        try:
            data = self._socket.recv(MAX_READ_BYTES)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionResetError(errno.ECONNRESET, "the other end has closed it")
        return data

    def answer(self) -> None:
        """There is only one at the other end."""

    def write(self, data: bytes) -> None:
        self._socket.sendall(data)

    def stop(self, data: bytes) -> None:
        self.write(data)

    def close(self) -> None:
        self._socket.close()


class _UdpLine:
    """Sends to an address, or listens and answers the address of the rover's last message."""

    def __init__(self, address: Address) -> None:
        found = socket.getaddrinfo(address.where, address.port, type=socket.SOCK_DGRAM)
        family, _, _, _, where = found[0]
        self._to: Any = None if address.kind == "udpin" else where
        self._sender: Any = None
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            if address.kind == "udpin":
                self._socket.bind(where)
        except OSError:
            self._socket.close()
            raise
        self._socket.settimeout(READ_TIMEOUT_S)

    def read(self) -> bytes:
        try:
            data, self._sender = self._socket.recvfrom(MAX_READ_BYTES)
        except (TimeoutError, ConnectionRefusedError):
            return b""  # nobody listens there yet
        return data

    def answer(self) -> None:
        self._to = self._sender

    def write(self, data: bytes) -> None:
        if self._to is None:
            return
        try:
            self._socket.sendto(data, self._to)
        except ConnectionRefusedError:
            return
        except OSError as error:
            # The network may come back; unsent messages are repeated anyway.
            if error.errno not in (errno.ENETUNREACH, errno.EHOSTUNREACH, errno.ENOBUFS):
                raise

    def stop(self, data: bytes) -> None:
        self.write(data)

    def close(self) -> None:
        self._socket.close()
