"""Checks whether the ports are free, or used by a WAX server."""

from __future__ import annotations

import errno
import socket
import ssl
import urllib.request
from typing import TYPE_CHECKING, Any, Final

from pydantic_core import from_json

from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.edge.binding import NOT_HERE, addresses, advice
from wax.errors import reason_of

if TYPE_CHECKING:
    from wax.commands.doctor.network import ServedNetwork

_ANSWER_S: Final = 2.0


def is_running(network: ServedNetwork) -> bool:
    """Whether a WAX server answers at the configured port of this machine."""
    if network.tcp_port == 0:
        return False
    host = "127.0.0.1" if network.is_everywhere else network.host
    scheme = "http" if network.certificate is None else "https"
    url = f"{scheme}://{f'[{host}]' if ':' in host else host}:{network.tcp_port}/healthz"
    # Only whether it is there is asked; who it is shows in the file of the certificate.
    opener = urllib.request.build_opener(
        urllib.request.ProxyHandler({}),
        urllib.request.HTTPSHandler(context=ssl._create_unverified_context()),
    )
    try:
        with opener.open(url, timeout=_ANSWER_S) as answer:
            return from_json(answer.read(1000)).get("ok") is True
    except (OSError, ValueError, AttributeError):
        return False


def tcp_port(network: ServedNetwork, *, running: bool) -> Verdict:
    """Check whether the page's port is available."""
    name = f"TCP port {network.tcp_port}"
    if running:
        return ok(f"{name} is served by WAX, which is running.")
    if network.tcp_port == 0:
        return warning(
            "Each start takes another TCP port.",
            "Set server.port, so that a router can forward it.",
        )
    return _bound(name, socket.SOCK_STREAM, network.host, network.tcp_port, "server.port")


def udp_port(network: ServedNetwork, *, running: bool) -> Verdict:
    """Check whether the port of picture, sound and commands is available."""
    if network.udp_port is None and network.stun:
        return ok("Each viewer gets a UDP port of its own, which is opened from here.")
    if network.udp_port is None:
        return warning(
            "Each viewer gets a random UDP port, which no router can forward.",
            'Set network.mode = "one-port" if viewers come from other networks.',
        )
    name = f"UDP port {network.udp_port}"
    if network.udp_port == 0:
        return warning(
            "Each start takes another UDP port.", "Set network.udp_port for a router to forward."
        )
    if running:
        return ok(f"{name} belongs to WAX, which is running.")
    return _bound(name, socket.SOCK_DGRAM, network.host, network.udp_port, "network.udp_port")


def _bound(name: str, kind: socket.SocketKind, host: str, port: int, key: str) -> Verdict:
    try:
        found = addresses(host or None, port, kind)
    except socket.gaierror:
        unknown = OSError(errno.EADDRNOTAVAIL, "")
        return bad(f"There is no address for the name {host}.", advice(unknown, key))
    errors = [_bind(family, kind, address) for family, address in found]
    # A name may have an address of a family that is switched off: the other one serves.
    told = [one for one in errors if one is not None and one.errno not in NOT_HERE]
    if not told and None not in errors:
        told = [one for one in errors if one is not None]
    for error in told:
        return bad(f"{name} cannot be used: {reason_of(error)}.", advice(error, key))
    return ok(f"{name} is free.")


def _bind(family: int, kind: socket.SocketKind, address: Any) -> OSError | None:
    """Bind a socket as the server does, and close it; return why that fails, None if it works."""
    try:
        with socket.socket(family, kind) as line:
            if kind == socket.SOCK_STREAM:
                line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                line.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            line.bind(address)
    except OSError as error:
        return error
    return None
