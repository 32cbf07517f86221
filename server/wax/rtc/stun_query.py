"""Asks a STUN server at which address it sees this machine (RFC 8489)."""

from __future__ import annotations

import datetime
import socket
import struct
from typing import Final, NamedTuple

from aioice import stun

from wax.errors import WaxError
from wax.unreachable import Target, why

DEFAULT_PORT: Final = 3478
_TRIES_S: Final = (0.5, 1.0, 1.5)
"""Retransmit after the RTO and twice that (6.2.1), but do not wait for the full 40 s."""
_MAX_BYTES: Final = 1500


class StunError(WaxError):
    """The STUN server cannot be asked, or does not answer."""


class StunAnswer(NamedTuple):
    """The address under which a STUN server saw `own`, one of this machine's."""

    public: str
    own: str


def public_address(server: str) -> str:
    """Return the address that a server sees, as `ask` does."""
    return ask(server).public


def ask(server: str) -> StunAnswer:
    """Ask `server`, as ``HOST`` or ``HOST:PORT``; raises `StunError`.

    Blocks for at most 3 s plus the name's lookup.
    """
    host, port = split(server)
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[
            0
        ]
        with socket.socket(family, kind, protocol) as line:
            line.connect(address)  # so that nobody else can answer
            for pause_s in _TRIES_S:
                request = stun.Message(stun.Method.BINDING, stun.Class.REQUEST)
                line.send(bytes(request))
                line.settimeout(pause_s)
                try:
                    found = _mapped(line.recv(_MAX_BYTES), request.transaction_id)
                except TimeoutError:
                    continue
                if found is not None:
                    return StunAnswer(found, line.getsockname()[0])
    except OSError as error:
        target = Target("stun", host, port, _TRIES_S[-1])
        told = why(target, error, datetime.datetime.now(datetime.UTC))
        raise StunError(f"The STUN server {server} cannot be asked. {told}") from error
    raise StunError(f"The STUN server {server} does not answer.")


def split(server: str) -> tuple[str, int]:
    """Return host and port of ``HOST``, ``HOST:PORT``, or ``[IPv6]:PORT``; raises `StunError`."""
    host, colon, port = server.rpartition(":")
    if not colon or server.endswith("]"):
        return server.strip("[]"), DEFAULT_PORT
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise StunError(f"{server} is no STUN server; write it as stun.example.org:3478.")
    return host.strip("[]"), int(port)


def _mapped(data: bytes, transaction_id: bytes) -> str | None:
    """Return the address in an answer to our request, None for anything else."""
    try:
        answer = stun.parse_message(data)
    except (ValueError, struct.error):
        return None
    if answer.transaction_id != transaction_id or answer.message_class != stun.Class.RESPONSE:
        return None
    mapped = answer.attributes.get("XOR-MAPPED-ADDRESS") or answer.attributes.get("MAPPED-ADDRESS")
    return None if mapped is None else str(mapped[0])
