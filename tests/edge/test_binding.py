"""Listening on the addresses of a host that this machine has."""

from __future__ import annotations

import errno
import socket
from pathlib import Path
from typing import Any

import pytest
from tests.free_port import free_port

from wax.edge.binding import listen, why_not


def _without_ipv6(monkeypatch: pytest.MonkeyPatch, number: int, family: int) -> None:
    """Resolve the name to both families, and let one of them fail to bind."""
    both = [
        (socket.AF_INET6, socket.SOCK_STREAM, 6, "", ("::1", 0, 0, 0)),
        (socket.AF_INET, socket.SOCK_STREAM, 6, "", ("127.0.0.1", 0)),
    ]
    create = socket.create_server

    def fail(address: Any, **more: Any) -> socket.socket:
        if family in (0, more["family"]):
            raise OSError(number, "injected")
        return create(address, **more)

    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: both)
    monkeypatch.setattr(socket, "create_server", fail)


@pytest.mark.parametrize("number", [errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT])
def test_a_disabled_family_is_left_out(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """Where `::1` cannot be bound, the server listens on 127.0.0.1."""
    _without_ipv6(monkeypatch, number, socket.AF_INET6)
    (made,) = listen("localhost", 0)
    with made:
        assert made.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize(
    ("number", "family"), [(errno.EADDRNOTAVAIL, 0), (errno.EADDRINUSE, socket.AF_INET6)]
)
def test_no_address_or_a_used_one_raises(
    monkeypatch: pytest.MonkeyPatch, number: int, family: int
) -> None:
    """A host without an address on this machine is an error, and so is a port in use."""
    _without_ipv6(monkeypatch, number, family)
    with pytest.raises(OSError, match="injected"):
        listen("localhost", 0)


def test_localhost_needs_no_resolver(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a resolver, localhost is this machine, and any other name is an error."""

    def fail(*_: Any, **__: Any) -> None:
        raise socket.gaierror(socket.EAI_AGAIN, "injected")

    monkeypatch.setattr(socket, "getaddrinfo", fail)
    # Not port 0: the port that the system chooses may be in use in the other family.
    made = listen("localhost", free_port())
    assert ("127.0.0.1", made[0].getsockname()[1]) in [one.getsockname()[:2] for one in made]
    for one in made:
        one.close()
    with pytest.raises(socket.gaierror, match="injected"):
        listen("robot.example.org", 0)


def test_the_error_for_a_privileged_port_says_how_to_allow_it() -> None:
    """A service allows it by lines to uncomment in its unit; with a router, nobody needs it."""
    told = why_not(PermissionError(errno.EACCES, "Permission denied"), "--port")
    assert told.startswith("Permission denied. ")
    unit = Path(__file__).parents[2] / "config" / "deploy" / "wax.service"
    assert "\n#AmbientCapabilities=CAP_NET_BIND_SERVICE\n" in unit.read_text(encoding="utf-8")
    assert all(one in told for one in ("CAP_NET_BIND_SERVICE in wax.service", "--port", "1024"))
