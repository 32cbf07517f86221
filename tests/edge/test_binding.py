"""Listening on what there is of a host's addresses."""

from __future__ import annotations

import errno
import socket
from pathlib import Path
from typing import Any

import pytest
from tests.free_port import free_port

from wax.edge.binding import listen, why_not


def _without_ipv6(monkeypatch: pytest.MonkeyPatch, number: int, family: int) -> None:
    """Let the name be known by both families, and the binding of one fail."""
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
def test_a_family_that_is_off_is_left_out(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """Where `::1` cannot be bound the server listens on 127.0.0.1."""
    _without_ipv6(monkeypatch, number, socket.AF_INET6)
    (made,) = listen("localhost", 0)
    with made:
        assert made.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize(
    ("number", "family"), [(errno.EADDRNOTAVAIL, 0), (errno.EADDRINUSE, socket.AF_INET6)]
)
def test_none_or_a_used_one_raises(
    monkeypatch: pytest.MonkeyPatch, number: int, family: int
) -> None:
    """A host of which nothing is here, or whose port somebody has, is an error."""
    _without_ipv6(monkeypatch, number, family)
    with pytest.raises(OSError, match="injected"):
        listen("localhost", 0)


def test_localhost_needs_no_resolver(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing resolves names, localhost is this machine, and any other name an error."""

    def fail(*_: Any, **__: Any) -> None:
        raise socket.gaierror(socket.EAI_AGAIN, "injected")

    monkeypatch.setattr(socket, "getaddrinfo", fail)
    # Not any: that which the system gives for one family may be taken in the other.
    made = listen("localhost", free_port())
    assert ("127.0.0.1", made[0].getsockname()[1]) in [one.getsockname()[:2] for one in made]
    for one in made:
        one.close()
    with pytest.raises(socket.gaierror, match="injected"):
        listen("robot.example.org", 0)


def test_a_port_that_takes_a_right_says_how_to_give_it() -> None:
    """The service gets it by lines that wait in its unit; whoever has a router needs none."""
    told = why_not(PermissionError(errno.EACCES, "Permission denied"), "--port")
    assert told.startswith("Permission denied. ")
    unit = Path(__file__).parents[2] / "config" / "deploy" / "wax.service"
    assert "\n#AmbientCapabilities=CAP_NET_BIND_SERVICE\n" in unit.read_text(encoding="utf-8")
    assert all(one in told for one in ("CAP_NET_BIND_SERVICE in wax.service", "--port", "1024"))
