"""The configurations of the programs around WAX: Caddy or nginx in front, coturn for relays."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import os
import re
import shutil
import socket
import subprocess
import sys
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import aiohttp
import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer
from aioice import stun, turn
from tests.free_port import free_port

from wax.clock import SystemClock
from wax.commands.doctor.addresses import own_addresses
from wax.config.server import ServerSettings
from wax.web.entrance import Entrance
from wax.web.guards import Guards
from wax.web.routes import _tell_errors

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

pytestmark = pytest.mark.system

FOLDER = Path(__file__).parents[2] / "config" / "deploy"
CADDYFILE, NGINX = FOLDER / "Caddyfile", FOLDER / "nginx.conf"
TURNSERVER = FOLDER / "turnserver.conf"
CLIENT = "127.0.0.2"
"""The addresses from which requests reach the proxy, which is at 127.0.0.1."""
RULE = FOLDER / "turnserver.nft"


def _program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"there is no {name}")
    return found


def _has_ipv6() -> bool:
    try:
        with socket.socket(socket.AF_INET6) as line:
            line.bind(("::1", 0))
    except OSError:
        return False
    return True


@asynccontextmanager
async def _running(*command: str, until: str) -> AsyncIterator[list[str]]:
    """Run a program around a block, once it has printed `until`; yield its output."""
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT
    )
    said: list[str] = []
    assert process.stdout is not None
    try:
        async with asyncio.timeout(15):
            while not said or until not in said[-1]:
                line = (await process.stdout.readline()).decode(errors="replace")
                assert line, f"it ended: {said}"
                said.append(line)
        yield said
    finally:
        if process.returncode is None:
            process.terminate()
        said.append((await process.stdout.read()).decode(errors="replace"))
        await process.wait()


# --- Caddy -----------------------------------------------------------------------------------


def test_caddy_takes_every_line() -> None:
    """Caddy accepts the file, and would format it in the same way."""
    caddy = _program("caddy")
    validate = ("validate", "--adapter", "caddyfile", "--config", str(CADDYFILE))
    for arguments in (validate, ("fmt", str(CADDYFILE))):
        done = subprocess.run([caddy, *arguments], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert done.stdout == CADDYFILE.read_text(encoding="utf-8")


def put(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


async def test_no_client_names_its_own_address(tmp_path: Path) -> None:
    """Behind Caddy the forwarded address is the one it saw, and a large body is refused there."""
    bodies: list[int] = []

    async def tell(request: web.Request) -> web.Response:
        bodies.append(len(await request.read()))
        return web.json_response(dict(request.headers))

    application = web.Application(client_max_size=10**6)
    application.router.add_route("*", "/", tell)
    async with TestServer(application) as wax, aiohttp.ClientSession() as http:
        assert wax.port is not None
        async with _caddy(tmp_path, wax.port, CADDYFILE.read_text(encoding="utf-8")) as port:
            url = f"http://127.0.0.1:{port}/"
            claimed = {"X-Forwarded-For": "203.0.113.9", "X-Forwarded-Proto": "https"}
            async with http.get(url, headers=claimed) as answer:
                seen = await answer.json()
            assert (seen["X-Forwarded-For"], seen["X-Forwarded-Proto"]) == ("127.0.0.1", "http")
            assert seen["Host"] == f"127.0.0.1:{port}"
            async with http.post(url, data=b"x" * 60_000) as answer:
                assert answer.status == 200
            async with http.post(url, data=b"x" * 70_000) as answer:
                assert answer.status in (413, 502)
        assert bodies == [0, 60_000]


@asynccontextmanager
async def _caddy(folder: Path, wax: int, text: str) -> AsyncIterator[int]:
    """Run Caddy with a Caddyfile, in front of a port; yield Caddy's port."""
    caddy, port = _program("caddy"), free_port()
    # At every name, since a test uses more than one.
    text = put(text, "robot.example.org {", f"http://:{port} {{")
    text = put(text, "localhost:8080", f"127.0.0.1:{wax}")
    config = folder / "Caddyfile"
    config.write_text(f"{{\n\tadmin off\n}}\n{text}")
    arguments = ("run", "--adapter", "caddyfile", "--config", str(config))
    async with _running(caddy, *arguments, until="serving initial configuration"):
        yield port


@asynccontextmanager
async def _nginx(folder: Path, wax: int, text: str) -> AsyncIterator[int]:
    """Do the same by nginx, without HTTPS."""
    nginx, port = _program("nginx"), free_port()
    kept = [line for line in text.splitlines() if "ssl_certificate" not in line]
    text = put("\n".join(kept), "listen 443 ssl", f"listen 127.0.0.1:{port}")
    there = f"listen [::1]:{port};" if _has_ipv6() else ""
    text = put(text, "listen [::]:443 ssl;", there)
    text = put(text, "localhost:8080", f"127.0.0.1:{wax}")
    paths = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    temporary = "".join(f"{name}_temp_path {folder}/{name};\n" for name in paths)
    config = folder / "nginx.conf"
    config.write_text(
        f"daemon off; pid {folder}/pid; error_log stderr notice; events {{}}\n"
        f"http {{\naccess_log off;\n{temporary}{text}\n}}\n"
    )
    async with _running(nginx, "-c", str(config), until="start worker process "):
        yield port


@asynccontextmanager
async def _asked_for_sender() -> AsyncIterator[int]:
    """Serve a request's sender, as WAX sees it behind a proxy of this machine; yield a port."""
    settings = ServerSettings(
        host="127.0.0.1", port=0, names=["robot.example.org"], trusted_proxies=["127.0.0.1"]
    )
    guards = Guards(settings, SystemClock())

    async def tell(request: web.Request) -> web.Response:
        return web.json_response({"sender": guards.sender(request)})

    application = web.Application(middlewares=[_tell_errors, *guards.middlewares])
    application.on_response_prepare.append(guards.add_headers)
    application.router.add_post("/", tell)
    entrance = Entrance(application, settings, SystemClock())
    await entrance.open()
    try:
        yield entrance.port
    finally:
        await entrance.close()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8")
@pytest.mark.parametrize(
    ("proxy", "text", "drops"),
    [
        (_caddy, CADDYFILE.read_text(encoding="utf-8"), "\t\theader_up -Forwarded\n"),
        (_nginx, NGINX.read_text(encoding="utf-8"), '\t\tproxy_set_header Forwarded "";\n'),
    ],
    ids=["caddy", "nginx"],
)
async def test_nobody_chooses_their_address(
    tmp_path: Path, proxy: Any, text: str, drops: str
) -> None:
    """Whatever a client claims, WAX sees the address that the proxy saw, or refuses the request."""
    claims: tuple[dict[str, str], ...] = (
        {},
        {"X-Forwarded-For": "203.0.113.9"},
        {"Forwarded": "for=127.0.0.1"},
        {"Forwarded": "for=127.0.0.1;proto=https", "X-Forwarded-For": "127.0.0.1"},
        {"Forwarded": "for=unknown"},
    )
    here = aiohttp.TCPConnector(local_addr=(CLIENT, 0))
    async with _asked_for_sender() as wax, aiohttp.ClientSession(connector=here) as http:

        async def ask(port: int, claim: dict[str, str]) -> tuple[int, object]:
            url = f"http://127.0.0.1:{port}/"
            # As the page asks, with a port other than its scheme's.
            page = {"Origin": f"http://127.0.0.1:{port}"}
            async with http.post(url, headers=claim | page) as answer:
                return answer.status, (await answer.json()).get("sender")

        async with proxy(tmp_path, wax, text) as port:
            for claim in claims:
                assert await ask(port, claim) == (200, CLIENT)
        async with proxy(tmp_path, wax, put(text, drops, "")) as port:
            for claim in claims:
                expected = (400, None) if "Forwarded" in claim else (200, CLIENT)
                assert await ask(port, claim) == expected


def _below_a_path(text: str) -> str:
    """Apply the file's own advice for serving below a path."""
    lines = [line.strip() for line in text.splitlines()]
    at = next(n for n, line in enumerate(lines) if line.startswith("# Below a path"))
    first, second = re.findall("`([^`]+)`", lines[at])
    if "location / {" not in lines:
        return put(text, "\trequest_body {", f"\t{first}\n\t{second}\n\trequest_body {{")
    text = put(text, "\tlocation / {", f"\t{first}")
    return put(text, "\t\tproxy_pass http://localhost:8080;", f"\t\t{second}")


@pytest.mark.parametrize(
    ("proxy", "text"),
    [
        (_caddy, CADDYFILE.read_text(encoding="utf-8")),
        (_nginx, NGINX.read_text(encoding="utf-8")),
    ],
    ids=["caddy", "nginx"],
)
async def test_a_path_and_ipv6_change_nothing(tmp_path: Path, proxy: Any, text: str) -> None:
    """Below a path, as the file advises, and at another port, a POST works by IPv4 and IPv6."""
    if not _has_ipv6():
        pytest.skip("this machine has no IPv6")
    async with (
        _asked_for_sender() as wax,
        proxy(tmp_path, wax, _below_a_path(text)) as port,
        aiohttp.ClientSession() as http,
    ):
        for name, sender in (("127.0.0.1", "127.0.0.1"), ("[::1]", "::/64")):
            origin = f"http://{name}:{port}"
            async with http.post(f"{origin}/robot/", headers={"Origin": origin}) as answer:
                assert (answer.status, await answer.json()) == (200, {"sender": sender})
            async with http.get(f"{origin}/robot", allow_redirects=False) as answer:
                assert answer.status in (301, 302)
                assert answer.headers["Location"].endswith("/robot/")


# --- coturn ----------------------------------------------------------------------------------

SECRET = "a-secret-of-the-test"
LOOPBACK = ("127.0.0.1", "::1")
Relay = turn.TurnClientUdpProtocol | turn.TurnClientTcpProtocol


@asynccontextmanager
async def relay(
    port: int, secret: str, over: str = "udp", *, host: str = "127.0.0.1"
) -> AsyncIterator[Relay]:
    """Get a relay as a browser does, with a name and password that WAX derives from the secret."""
    name = f"{SystemClock().wall_ms() // 1000 + 600}:ada"
    digest = hmac.digest(secret.encode(), name.encode(), hashlib.sha1)
    password = base64.b64encode(digest).decode()
    server = (host, port)
    who, loop = (server, name, password, 600, 500), asyncio.get_running_loop()
    transport: asyncio.BaseTransport
    client: Relay
    if over == "udp":
        transport, client = await loop.create_datagram_endpoint(
            lambda: turn.TurnClientUdpProtocol(*who), remote_addr=server
        )
    else:
        transport, client = await loop.create_connection(
            lambda: turn.TurnClientTcpProtocol(*who), *server
        )
    try:
        await client.connect()
        yield client
        await client.delete()
    finally:
        transport.close()


def _own_address() -> str:
    found = [str(address) for _, address in own_addresses() if address.version == 4]
    if not found:
        pytest.skip("this machine has no address but loopback, to which coturn relays nothing")
    return found[0]


@asynccontextmanager
async def coturn(
    folder: Path, wax: str, port: int | None = None
) -> AsyncIterator[tuple[int, list[str]]]:
    """Run coturn as configured, for a WAX at this address; yield its port and its output."""
    turnserver = _program("turnserver")
    text = TURNSERVER.read_text(encoding="utf-8")
    text = put(text, "static-auth-secret=CHANGE-ME", f"static-auth-secret={SECRET}")
    text = put(text, "allowed-peer-ip=203.0.113.5", f"allowed-peer-ip={wax}")
    if ":" in wax:
        text = put(text, "#allocation-default", "allocation-default")
    config = folder / "turnserver.conf"
    config.write_text(text)
    port = port or free_port(socket.SOCK_DGRAM)
    host = LOOPBACK[":" in wax]
    here = ("-L", host, "-E", wax, "-p", str(port), "--pidfile", str(folder / "pid"))
    command = (turnserver, "-c", str(config), *here, "-b", str(folder / "db"))
    async with _running(*command, until="IO method (auth thread)") as said:
        yield port, said


async def test_a_relay_leads_to_wax_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the secret one gets a relay, which reaches WAX's address by UDP and nothing else."""
    ours = _own_address()
    loop = asyncio.get_running_loop()
    async with coturn(tmp_path, ours) as (port, said):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wax:
            wax.bind((ours, 0))
            wax.setblocking(False)
            async with relay(port, SECRET) as relaying, asyncio.timeout(10):
                await relaying.send_data(b"hello", wax.getsockname())
                assert await loop.sock_recv(wax, 99) == b"hello"
                for denied in ("192.0.2.77", "10.0.0.1", "127.0.0.1"):
                    with pytest.raises(stun.TransactionFailed, match="403"):
                        await relaying.send_data(b"hello", (denied, 9))
        with pytest.raises(stun.TransactionFailed, match="401"):
            async with relay(port, "another secret"):
                pass
        async with relay(port, SECRET, "tcp"):
            pass
        monkeypatch.setattr(turn, "UDP_TRANSPORT", 6 << 24)  # TCP to the peer, too (RFC 6062)
        with pytest.raises(stun.TransactionFailed, match="442"):
            async with relay(port, SECRET, "tcp"):
                pass
    wrong = [line for line in said if "Bad configuration" in line]
    assert wrong == []


@pytest.mark.parametrize("wax", ["198.51.100.5", "2001:db8::5"])
def test_a_relay_leads_to_its_port_alone(tmp_path: Path, wax: str) -> None:
    """With coturn's firewall rule, relays reach only one port of WAX's machine.

    By IPv4, and by IPv6, where each other address is denied, too.
    """
    for program in ("nft", "turnserver", "ip"):
        _program(program)
    alone = [_program("unshare"), "--net", *(["--map-root-user"] if os.getuid() else [])]
    if subprocess.run([*alone, "true"], check=False, capture_output=True).returncode:
        pytest.skip("no network of one's own can be made here")
    done = subprocess.run(
        [*alone, sys.executable, "-m", "tests.deploy.relay_port", str(tmp_path), wax],
        cwd=FOLDER.parents[1],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == ["8081 8082", "8081"], done.stderr
