"""Raw requests to the real application: which are answered, and with which headers."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

import pytest
from aiohttp.test_utils import BaseTestServer, TestServer
from tests.turned_clock import TurnedClock
from tests.web.foreign import FOREIGN_HOSTS, FOREIGN_ORIGINS, MALFORMED_HOSTS
from tests.web.rig import make_routes

from wax.config.server import ServerSettings
from wax.web import routes
from wax.web.guards import Guards
from wax.web.security_headers import base_headers

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.access.admission import Visitor
    from wax.access.permissions import Role

PATHS = (
    "/",
    "/assets/a.js",
    "/api/status",
    "/api/ice",
    "/healthz",
    "/nothing",
    "/api/proof/record",
)
GOOD = b'{"sdp": "v=0", "client": "12345678-abcd"}'


class Deaf:
    """A room that counts the offers it gets."""

    def __init__(self) -> None:
        self.asked = 0

    def role_of(self, visitor: Visitor) -> Role:
        return "host"

    def file_sent(self, visitor: Visitor, size_bytes: int) -> float | None:
        return None

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        self.asked += 1
        return "v=0 answer"


class Answer:
    """What came back over one connection."""

    def __init__(self, raw: bytes) -> None:
        head, _, self.body = raw.partition(b"\r\n\r\n")
        first, *lines = head.decode("latin-1").split("\r\n")
        self.status = int(first.split(" ")[1])
        self.headers = dict(line.split(": ", 1) for line in lines)


class Line:
    """Raw connections to one server, each for one request."""

    def __init__(self, server: BaseTestServer, room: Deaf) -> None:
        assert server.port is not None
        self.port = server.port
        self.room = room

    @property
    def host(self) -> bytes:
        return b"Host: 127.0.0.1:%d" % self.port

    async def ask(self, first: bytes, *headers: bytes, body: bytes = b"") -> Answer:
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        length = (b"Content-Length: %d" % len(body),) if body else ()
        lines = (first, *headers, *length, b"Connection: close", b"", body)
        try:
            writer.write(b"\r\n".join(lines))
            return Answer(await asyncio.wait_for(reader.read(), 5))
        finally:
            writer.close()
            await writer.wait_closed()


@pytest.fixture
async def line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> AsyncIterator[Line]:
    trusted = getattr(request, "param", ["127.0.0.1"])
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html>")
    (tmp_path / "assets" / "a.js").write_text("1")
    monkeypatch.setattr(routes, "PAGE", tmp_path)
    room, clock = Deaf(), TurnedClock()
    made = make_routes(
        room,
        offers_hz=1000.0,
        guards=Guards(
            ServerSettings(names=["robots.example"], trusted_proxies=trusted),
            clock,
            lambda: ["203.0.113.7", "2001:db8::7"],
        ),
    )
    async with TestServer(made.application()) as server:
        yield Line(server, room)


async def test_a_request_for_another_host(line: Line) -> None:
    """A name that somebody else points at this machine gets nothing, whatever is requested."""
    for name in FOREIGN_HOSTS:
        answer = await line.ask(b"GET / HTTP/1.1", b"Host: " + name.encode())
        assert answer.status == 421, name
        assert "does not go by that name" in json.loads(answer.body)["error"]
    for path in PATHS:
        for method in ("GET", "HEAD", "POST", "OPTIONS", "DELETE"):
            first = f"{method} {path} HTTP/1.1".encode()
            assert (await line.ask(first, b"Host: evil.example")).status == 421, (method, path)


async def test_a_malformed_host(line: Line) -> None:
    """Anything but a name or an address gets 400, and reaches neither page nor robot."""
    for text in (text for text in MALFORMED_HOSTS if text.strip() == text):
        raw = b"Host: " + text.encode("utf-8", "surrogateescape")
        assert (await line.ask(b"GET / HTTP/1.1", raw)).status == 400, text
        assert (await line.ask(b"POST /api/offer HTTP/1.1", raw, body=GOOD)).status == 400, text
    assert line.room.asked == 0


async def test_hosts_that_are_missing_double_or_in_the_target(line: Line) -> None:
    """No Host, two of them, or a target that names a foreign host is refused."""
    evil = b"Host: evil.example"
    assert (await line.ask(b"GET / HTTP/1.0")).status == 400
    assert (await line.ask(b"GET / HTTP/1.1")).status == 400
    assert (await line.ask(b"GET / HTTP/1.1", line.host, evil)).status == 400
    assert (await line.ask(b"GET / HTTP/1.1", evil, line.host)).status == 400
    assert (await line.ask(b"GET http://evil.example/ HTTP/1.1", line.host)).status == 421
    assert (await line.ask(b"GET http://127.0.0.1/ HTTP/1.1", evil)).status == 421
    assert (await line.ask(b"GET http://[/ HTTP/1.1", line.host)).status == 400
    assert (await line.ask(b"GET http://127.0.0.1/ HTTP/1.1", line.host)).status == 200
    assert (await line.ask(b"GET / HTTP/1.0", line.host)).status == 200


async def test_a_load_balancer_asks_for_health_without_a_name(line: Line) -> None:
    """HAProxy does so by HTTP/1.0, for health only; HTTP/1.1, and so browsers, must name us."""
    for path in (b"/healthz", b"/readyz"):
        for method in (b"GET", b"HEAD"):
            assert (await line.ask(b"%s %s HTTP/1.0" % (method, path))).status == 200
        assert (await line.ask(b"GET %s HTTP/1.1" % path)).status == 400
        assert (await line.ask(b"POST %s HTTP/1.0" % path)).status == 400
        assert (await line.ask(b"GET %s HTTP/1.0" % path, b"Host: evil.example")).status == 421
        assert (await line.ask(b"GET %s HTTP/1.0" % path, b"Host: [")).status == 400
    for path in (b"/", b"/api/status", b"/healthz/", b"/assets/a.js"):
        assert (await line.ask(b"GET %s HTTP/1.0" % path)).status == 400


async def test_our_own_names(line: Line) -> None:
    """The configured name, this machine's own and its router's are answered, for all files."""
    routers = (b"203.0.113.7:8080", b"[2001:DB8::7]:8080")
    for name in (b"robots.example", b"localhost:1", b"127.0.0.1", b"ROBOTS.example:443", *routers):
        for path in (b"/", b"/assets/a.js", b"/healthz"):
            assert (await line.ask(b"GET %s HTTP/1.1" % path, b"Host: " + name)).status == 200


async def test_another_sites_page(line: Line) -> None:
    """Another site's page changes nothing here, however its origin is written."""
    ours = f"127.0.0.1:{line.port}"
    forms = [(b"/api/offer", form) for form in FOREIGN_ORIGINS]
    others = (b"/api/stop", b"/api/release", b"/api/proof", b"/nothing")
    for path, form in forms + [(other, FOREIGN_ORIGINS[0]) for other in others]:
        origin = form.replace("robot:8080", ours).replace("robot", "127.0.0.1").strip().encode()
        first = b"POST %s HTTP/1.1" % path
        answer = await line.ask(first, line.host, b"Origin: " + origin, body=GOOD)
        assert answer.status == 403, (path, origin)
    assert line.room.asked == 0


@pytest.mark.parametrize("site", [b"cross-site", b"same-site", b"SAME-ORIGIN", b"", b"none, none"])
async def test_another_site_by_its_own_word(line: Line, site: bytes) -> None:
    """Fetch Metadata counts even if the origin is right or missing."""
    first, said = b"POST /api/offer HTTP/1.1", b"Sec-Fetch-Site: " + site
    origin = b"Origin: http://127.0.0.1:%d" % line.port
    assert (await line.ask(first, line.host, said, body=GOOD)).status == 403
    assert (await line.ask(first, line.host, said, origin, body=GOOD)).status == 403
    assert line.room.asked == 0


async def test_our_own_page_and_programs(line: Line) -> None:
    """Our page may send an offer, and so may a program that is no browser."""
    first = b"POST /api/offer HTTP/1.1"
    origin = b"Origin: http://127.0.0.1:%d" % line.port
    site = b"Sec-Fetch-Site: same-origin"
    assert (await line.ask(first, line.host, body=GOOD)).status == 200
    assert (await line.ask(first, line.host, origin, site, body=GOOD)).status == 200


@pytest.mark.parametrize(
    "path", [b"/" + b"a" * 299, b"/assets/" + b"%2e" * 100, b"/%00", b"/a%00b"]
)
async def test_paths_that_no_file_can_have(line: Line, path: bytes) -> None:
    """A path that is too long, or contains a zero, is not found, and no error of ours."""
    answer = await line.ask(b"GET %s HTTP/1.1" % path, line.host)
    assert answer.status == 404
    assert json.loads(answer.body)["error"]


def test_the_page_may_connect_to_the_rooms_and_nowhere_else() -> None:
    """Observers in LiveKit rooms connect to that server, by WebSocket and HTTP."""
    assert "connect-src 'self';" in base_headers()["Content-Security-Policy"]
    there = ["wss://livekit.example.org/a", "wss://livekit.example.org", "ws://127.0.0.1:7880"]
    policy = base_headers(there)["Content-Security-Policy"]
    assert (
        "connect-src 'self' wss://livekit.example.org https://livekit.example.org"
        " ws://127.0.0.1:7880 http://127.0.0.1:7880;"
    ) in policy


@pytest.mark.parametrize(
    ("path", "host"),
    [(path, None) for path in PATHS] + [("/", b"Host: evil.example"), ("/", b"Host: [")],
)
async def test_every_answer_is_protected(line: Line, path: str, host: bytes | None) -> None:
    """Pages, files, refusals and errors have the headers; answers of /api are never cached."""
    answer = await line.ask(f"GET {path} HTTP/1.1".encode(), host or line.host)
    policy = answer.headers["Content-Security-Policy"]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'self'"
    assert not rules.keys() & {"script-src", "style-src"}, "neither is more than the default"
    assert "unsafe" not in policy
    assert "*" not in policy
    assert answer.headers["Cross-Origin-Opener-Policy"] == "same-origin"
    assert answer.headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert answer.headers["Referrer-Policy"] == "no-referrer"
    assert "camera=()" in answer.headers["Permissions-Policy"]
    assert "gamepad=(self)" in answer.headers["Permissions-Policy"]
    assert "xr-spatial-tracking=(self)" in answer.headers["Permissions-Policy"]
    assert "Strict-Transport-Security" not in answer.headers
    assert (answer.headers.get("Cache-Control") == "no-store") == path.startswith("/api/")


@pytest.mark.parametrize(
    ("site", "policy"),
    [("same-origin", "unsafe-none"), ("same-site", "same-origin"), ("cross-site", "same-origin")],
)
async def test_only_a_page_of_ours_is_an_opener(line: Line, site: str, policy: str) -> None:
    """A frame with `sandbox` cannot open a page that isolates itself from its opener."""
    answer = await line.ask(b"GET / HTTP/1.1", line.host, f"Sec-Fetch-Site: {site}".encode())
    assert answer.headers["Cross-Origin-Opener-Policy"] == policy


async def test_a_public_name_stays_with_https(line: Line) -> None:
    """HSTS is sent for a configured name, and never for localhost, where others serve, too."""
    https = b"X-Forwarded-Proto: https"
    for host, told in ((b"robots.example", True), (b"localhost", False), (b"127.0.0.1", False)):
        answer = await line.ask(b"GET / HTTP/1.1", b"Host: " + host, https)
        assert ("Strict-Transport-Security" in answer.headers) == told
    answer = await line.ask(b"GET / HTTP/1.1", b"Host: robots.example")
    assert "Strict-Transport-Security" not in answer.headers


async def test_behind_a_proxy_the_page_has_the_proxys_origin(line: Line) -> None:
    """A trusted proxy's scheme and host count; without them, nothing is assumed."""
    first, host = b"POST /api/offer HTTP/1.1", b"Host: robots.example"
    origin, https = b"Origin: https://robots.example", b"X-Forwarded-Proto: https"
    assert (await line.ask(first, host, origin, https, body=GOOD)).status == 200
    inside = b"Host: inside:8080"
    assert (await line.ask(first, inside, origin, https, body=GOOD)).status == 421
    named = b"X-Forwarded-Host: robots.example"
    assert (await line.ask(first, inside, origin, https, named, body=GOOD)).status == 200


@pytest.mark.parametrize(
    ("line", "headers", "code"),
    [
        (["127.0.0.1"], [b"Origin: https://robots.example"], "request.other_than_proxy"),
        (
            ["127.0.0.1"],
            [b"Origin: https://robots.example", b"Sec-Fetch-Site: cross-site"],
            "request.other_site",
        ),
        ([], [b"Origin: https://robots.example"], "request.other_origin"),
    ],
    indirect=["line"],
)
async def test_a_refused_origin_says_what_to_do(
    line: Line, headers: list[bytes], code: str
) -> None:
    """A trusted proxy must send the scheme, another must be listed; a foreign page gets no hint."""
    first, host = b"POST /api/offer HTTP/1.1", b"Host: robots.example"
    answer = await line.ask(first, host, *headers, body=GOOD)
    assert answer.status == 403
    told = json.loads(answer.body)
    assert told["sentence"]["code"] == code
    assert ("X-Forwarded-Proto expr=%{REQUEST_SCHEME}" in told["error"]) == ("proxy" in code)
    assert line.room.asked == 0
