"""Ports that are free, taken, ours or unavailable; with real sockets."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer
from tests.free_port import free_port

from wax.commands.doctor import ports
from wax.commands.doctor.network import network_of
from wax.config.settings import Settings
from wax.web.certificate import Certificate, kept_in

if TYPE_CHECKING:
    from tests.commands.doctor.conftest import MakeNetwork

KINDS = pytest.mark.parametrize("kind", [socket.SOCK_STREAM, socket.SOCK_DGRAM])


def _look(network: Any, kind: socket.SocketKind) -> Any:
    look = ports.tcp_port if kind == socket.SOCK_STREAM else ports.udp_port
    return look(network, running=False)


@KINDS
def test_a_port_is_free_until_somebody_has_it(
    network: MakeNetwork, kind: socket.SocketKind
) -> None:
    """A taken port is bad, with how to find its owner; a free one is ok."""
    with socket.socket(socket.AF_INET, kind) as other:
        other.bind(("127.0.0.1", free_port(kind)))
        if kind == socket.SOCK_STREAM:
            other.listen()
        port = other.getsockname()[1]
        ours = network(host="127.0.0.1", tcp_port=port, udp_port=port)
        taken = _look(ours, kind)
    assert (taken.level, str(port) in taken.sentence, "ss -" in taken.advice) == ("bad", True, True)
    assert _look(ours, kind).level == "ok"


@KINDS
@pytest.mark.parametrize("host", ["192.0.2.99", "no.such.host.invalid"])
def test_an_address_that_is_not_ours_is_bad(
    network: MakeNetwork, kind: socket.SocketKind, host: str
) -> None:
    """An address of another machine, or an invalid one, is bad."""
    verdict = _look(network(host=host, tcp_port=18080, udp_port=18080), kind)
    assert (verdict.level, "server.host" in verdict.advice) == ("bad", True)


@KINDS
def test_one_family_of_addresses_suffices(
    network: MakeNetwork, monkeypatch: pytest.MonkeyPatch, kind: socket.SocketKind
) -> None:
    """A name with two addresses, one of which this machine lacks, is ok."""
    here = (socket.AF_INET, kind, 0, "", ("127.0.0.1", 0))
    elsewhere = (socket.AF_INET, kind, 0, "", ("192.0.2.99", 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [elsewhere, here])
    assert _look(network(host="pi", tcp_port=18080), kind).level == "ok"


def test_a_port_that_changes_cannot_be_forwarded(network: MakeNetwork) -> None:
    """Random ports, TCP or UDP, are reported."""
    assert ports.tcp_port(network(tcp_port=0), running=False).level == "warning"
    for number in (None, 0):
        assert ports.udp_port(network(udp_port=number), running=False).level == "warning"


@pytest.mark.parametrize(
    ("body", "is_ours"),
    [
        *(('{"ok": true}', True), ('{"ok": 1}', False)),
        *(("[]", False), ("", False), ("[" * 1000, False)),
    ],
)
async def test_only_our_own_server_may_have_it(
    network: MakeNetwork, body: str, *, is_ours: bool
) -> None:
    """Only a server that answers as WAX counts as running."""

    async def health(_: web.Request) -> web.Response:
        return web.Response(text=body)

    application = web.Application()
    application.router.add_get("/healthz", health)
    async with TestServer(application) as server:
        ours = network(host="127.0.0.1", tcp_port=server.port)
        assert await asyncio.to_thread(ports.is_running, ours) is is_ours
    assert ports.tcp_port(ours, running=True).level == "ok"
    assert ports.udp_port(ours, running=True).level == "ok"


def test_nobody_answers_where_nobody_is(network: MakeNetwork) -> None:
    """Without a server at the port, or without a fixed port, none is running."""
    assert not ports.is_running(network(host="127.0.0.1", tcp_port=free_port()))
    assert not ports.is_running(network(tcp_port=0))


@pytest.mark.parametrize(
    ("host", "is_local"),
    [("localhost", True), ("127.0.0.1", True), ("::1", True), ("0.0.0.0", False), ("pi", False)],
)
def test_it_is_told_who_can_open_the_page(host: str, *, is_local: bool) -> None:
    """Only a page on loopback is local."""
    settings = Settings.model_validate({"server": {"host": host}})
    assert network_of(settings).is_local is is_local


def _settings(**server: Any) -> Settings:
    network = {"udp_port": 9, "public_addresses": ["192.0.2.1"], "stun": ["stun:a:1"]}
    return Settings.model_validate({"server": server, "network": network})


def test_a_server_given_goes_before_those_configured() -> None:
    """`--stun` replaces the configuration's servers."""
    assert network_of(_settings()).stun == ("a:1",)
    assert network_of(_settings(), "b:2").stun == ("b:2",)
    assert network_of(_settings()).ports == "TCP port 8080 and UDP port 9"


def test_the_kind_of_https_is_read(tmp_path: Path) -> None:
    """HTTPS by files, by a self-signed certificate, by a proxy, or none, is told apart."""
    files = network_of(_settings(certificate="/c", key="/k", https=True))
    assert (files.certificate, files.is_self_signed) == (Certificate(Path("/c"), Path("/k")), False)
    own = network_of(_settings(https=True, state_dir=str(tmp_path)))
    assert (own.certificate, own.is_self_signed) == (kept_in(tmp_path), True)
    plain = network_of(_settings(trusted_proxies=["::1"]))
    assert (plain.certificate, plain.is_behind_proxy) == (None, True)
