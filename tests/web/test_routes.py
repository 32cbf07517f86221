"""The HTTP routes: every refusal is JSON with one sentence, and changes need our own page."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import shutil
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final, cast

import pytest
from aiohttp import CookieJar
from aiohttp.test_utils import TestClient, TestServer
from aiohttp.web import BaseRequest
from tests.examples import at_length
from tests.turned_clock import TurnedClock
from tests.visitors import make_access
from tests.web.pictures import encoded
from tests.web.rig import Lent, make_routes

from wax.access.access import Shown
from wax.access.admission import Visitor
from wax.config.network import NetworkSettings
from wax.config.opening_hours import OpeningHours
from wax.config.page import PageSettings
from wax.config.relay import RelaySettings
from wax.config.server import ServerSettings
from wax.errors import ForbiddenError, FullError, NoPlaceError, SignallingError, StartError
from wax.records.records import Records
from wax.rtc.ice_servers import IceServers
from wax.web import routes
from wax.web.branding import BrandedPage
from wax.web.guards import Guards
from wax.web.opening_calendar import OpeningCalendar
from wax.web.request_budgets import HOST

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from aiohttp.web import Application, Request

    from wax.access.access import Access
    from wax.access.permissions import Role

    Client = TestClient[Request, Application]

PACKED: Final = {"Content-Encoding": "gzip", "Content-Type": "application/json"}
GOOD = {"sdp": "v=0", "client": "12345678-abcd"}


@dataclass(frozen=True)
class Told:
    """A stand-in for any message."""

    what: str
    is_somebody: bool

    def model_dump_json(self) -> str:
        return json.dumps(asdict(self))


class FakeRoom:
    """A room that answers every offer in the same way."""

    def __init__(self) -> None:
        self.error: Exception | None = None
        self.full: Exception | None = None
        self.offers: list[tuple[str, str]] = []
        self.accepted: list[tuple[str, str]] = []
        self.visitors: list[Visitor] = []
        self.missing: dict[str, str] = {}
        self.stops: list[tuple[object, ...]] = []
        self.left: list[tuple[str, str]] = []
        self.role: Role = "operator"
        self.file_waits_s: float | None = None
        self.pieces = 0

    def role_of(self, visitor: Visitor) -> Role:
        known = any(one.identity == visitor.identity for one in self.visitors)
        return "host" if visitor.is_host else self.role if known else "stranger"

    def by_tab(self, visitor: Visitor, tab: str) -> Visitor:
        tabs = [known for known, _ in self.offers]
        return self.visitors[tabs.index(tab)] if tab in tabs else visitor

    def file_sent(self, visitor: Visitor, size_bytes: int) -> float | None:
        self.pieces += self.file_waits_s is not None
        return self.file_waits_s

    def stop_by(self, visitor: Visitor, tab: str | None, press: int | None = None) -> int:
        self.stops.append((tab, press, visitor.is_host))
        return 7

    def release_by(self, visitor: Visitor, tab: str | None, stop: int) -> None:
        self.stops.append((tab, stop, visitor.is_host))
        if self.error is not None:
            raise self.error

    @property
    def rooms(self) -> FakeRoom:
        return self

    def seat_instead(self, visitor: Visitor, tab: str, here: NoPlaceError) -> Told:
        return self.seat(visitor, tab)

    def seat(self, visitor: Visitor, tab: str) -> Told:
        if self.full is not None:
            raise self.full
        return Told(f"seat of {tab}", bool(visitor.identity))

    def leave(self, visitor: Visitor, tab: str) -> None:
        self.left.append((visitor.identity, tab))

    @property
    def queue(self) -> FakeRoom:
        return self

    def request(self, visitor: Visitor, tab: str, wants: str, name: str | None) -> Told:
        return Told(f"{wants} of {tab}{name or ''}", bool(visitor.identity))

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        self.visitors.append(visitor)
        self.offers.append((tab, offer))
        if self.error is not None:
            raise self.error
        return "v=0 answer" if offer else "v=0 offer"

    async def accept(self, visitor: Visitor, tab: str, answer: str) -> None:
        self.visitors.append(visitor)
        self.accepted.append((tab, answer))


@pytest.fixture
def room() -> FakeRoom:
    return FakeRoom()


@pytest.fixture
def clock() -> TurnedClock:
    return TurnedClock()


@pytest.fixture
def lent() -> Lent:
    return Lent()


@pytest.fixture
def access(clock: TurnedClock) -> Access:
    return make_access(Records(clock), clock)


@pytest.fixture
async def client(
    room: FakeRoom, lent: Lent, access: Access, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[Client]:
    clock = cast("TurnedClock", access._clock)
    page = tmp_path / "dist"
    (page / "assets").mkdir(parents=True)
    (page / "index.html").write_text("<!doctype html>")
    (page / "assets" / "a.js").write_text("1")
    (page / "assets" / "b.js").write_text("2" * 1000)
    (page / "assets" / "b.js.gz").write_bytes(gzip.compress(b"2" * 1000))
    (tmp_path / "secret").write_text("2")
    monkeypatch.setattr(routes, "PAGE", page)
    made = make_routes(
        room,
        clock=clock,
        access=access,
        ice=IceServers(NetworkSettings(stun=["stun:stun.example:3478"]), RelaySettings()),
        status=lambda: {"version": "x"},
        proving=lent,
        guards=Guards(
            ServerSettings(trusted_proxies=["127.0.0.1"], names=["robot.example", "192.168.1.7"]),
            clock,
        ),
        missing=lambda: room.missing,
        calendar=OpeningCalendar(
            OpeningHours.of(["mon 09:00-18:00"], UTC),
            PageSettings(),
            "",
            lambda: datetime(2026, 10, 20, tzinfo=UTC),
        ),
    )
    cookies = CookieJar(unsafe=True)
    server = TestServer(made.application())
    await server.start_server(auto_decompress=False)  # as `Connection` has it
    async with TestClient(server, cookie_jar=cookies) as found:
        yield found


async def become_host(client: Client, access: Access) -> None:
    secret = access.new_host_link()
    assert (await client.post("/api/host", json={"secret": secret})).status == 200


@pytest.mark.parametrize(
    ("page_data", "html"),
    [
        ({}, '<html data-name="WAX" lang="en">'),
        ({"acknowledge": ""}, '<html data-name="WAX" data-acknowledge="" lang="en">'),
        ({"player": "browser"}, '<html data-name="WAX" data-player="browser" lang="en">'),
    ],
)
async def test_the_page_knows_what_to_prepare(
    room: FakeRoom,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    page_data: dict[str, str],
    html: str,
) -> None:
    """It knows before it connects: a page that learned it later would have to connect twice."""
    (tmp_path / "index.html").write_text('<!doctype html><html lang="en"></html>')
    monkeypatch.setattr(routes, "PAGE", tmp_path)
    made = make_routes(room, branding=BrandedPage(PageSettings(), page_data))
    async with TestClient(TestServer(made.application())) as client:
        page = await client.get("/")
        assert page.content_type == "text/html"
        assert html in await page.text()
        assert page.headers["Cache-Control"] == "no-cache"


def test_only_permitted_requests_are_urgent(room: FakeRoom, access: Access) -> None:
    """A viewer's Stop is, an operator's release, and all of a host's; none of a stranger's."""
    made = make_routes(room, access=access)
    cookie = access.new_identity(bound=True)
    shown = Shown(cookie)
    assert made.who(shown, "192.0.2.1", "POST /api/stop", "") is None
    identity = access.identity_of(shown)
    assert identity is not None
    room.visitors.append(Visitor(identity, "192.0.2.1"))
    room.offers.append(("their-tab", ""))
    roles: dict[Role, bool] = {"observer": False, "operator": True}
    for role, may_release in roles.items():
        room.role = role
        for route, is_urgent in (
            ("POST /api/stop", True),
            ("POST /api/release", may_release),
            ("GET /", False),
        ):
            assert made.who(shown, "192.0.2.1", route, "") == (identity, is_urgent)
            by_tab = (identity, True) if route == "POST /api/stop" else None
            assert made.who(Shown(), "192.0.2.1", route, "their-tab") == by_tab
            assert made.who(Shown(), "192.0.2.1", route, "another-tab") is None
    host = Shown(cookie, access.become_host(access.new_host_link()))
    assert made.who(host, "192.0.2.1", "GET /", "") == (HOST, True)


async def _served(
    settings: PageSettings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> TestClient[Request, Application]:
    """Make a client of a page with these settings."""
    page = tmp_path / "dist"
    page.mkdir()
    (page / "index.html").write_text('<!doctype html><html lang="en"><head></head></html>')
    monkeypatch.setattr(routes, "PAGE", page)
    made = make_routes(FakeRoom(), branding=BrandedPage(settings))
    return TestClient(TestServer(made.application()))


async def test_the_hosts_colours_and_picture_are_cached_by_url(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Browsers cache them for good by the URL in the page, and for an hour by another."""
    file = tmp_path / "robot.png"
    file.write_bytes(encoded("png"))
    settings = PageSettings(accent="#7a1fa2", picture=str(file))
    own = BrandedPage(settings)
    assert own.picture is not None
    async with await _served(settings, tmp_path, monkeypatch) as client:
        for path, digest, content_type in (
            ("/page.css", own.style_digest, "text/css"),
            ("/preview", own.picture.digest, "image/png"),
        ):
            kept = await client.get(f"{path}?{digest}")
            assert kept.content_type == content_type
            assert kept.headers["Cache-Control"] == "public, max-age=31536000, immutable"
            other = await client.get(f"{path}?0")
            assert other.headers["Cache-Control"] == "public, max-age=3600"
        preview = await client.get("/preview")
        assert await preview.read() == file.read_bytes()
        assert preview.headers["Cross-Origin-Resource-Policy"] == "cross-origin"


async def test_a_page_without_a_picture_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing else is served in its place; the empty style sheet changes no colour."""
    async with await _served(PageSettings(), tmp_path, monkeypatch) as client:
        answer = await client.get("/preview")
        assert answer.status == 404
        assert (await answer.json())["error"] == "This page has no picture."
        assert await (await client.get("/page.css")).text() == ""


async def test_the_opening_hours_are_a_cached_file(client: Client) -> None:
    """A client caches it for an hour, then asks whether it has changed, which builds nothing."""
    first = await client.get("/open.ics")
    assert (first.status, first.content_type) == (200, "text/calendar")
    assert (await first.read()).startswith(b"BEGIN:VCALENDAR\r\n")
    assert first.headers["Cache-Control"] == "public, max-age=3600"
    again = await client.get("/open.ics", headers={"If-None-Match": first.headers["ETag"]})
    assert (again.status, await again.read()) == (304, b"")


async def test_a_robot_that_is_always_open_has_no_calendar(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sentence says that it is always open."""
    async with await _served(PageSettings(), tmp_path, monkeypatch) as client:
        answer = await client.get("/open.ics")
        assert answer.status == 404
        assert (await answer.json())["sentence"] == {"code": "request.always_open"}


async def test_a_page_that_has_not_changed_is_not_sent_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A returning browser asks whether the page has changed, and uses its own copy."""
    async with await _served(PageSettings(), tmp_path, monkeypatch) as client:
        first = await client.get("/")
        tag = first.headers["ETag"]
        again = await client.get("/", headers={"If-None-Match": tag})
        assert (again.status, await again.text()) == (304, "")
        assert again.headers["Cache-Control"] == "no-cache"
        others = '"a",' * 1500
        for tags in (f"{others}{tag}", f"a b, {tag}"):
            one_of = await client.get("/", headers={"If-None-Match": tags})
            assert one_of.status == 304
        other = await client.get("/", headers={"If-None-Match": f'W/"other", {others[:-1]}'})
        assert (other.status, await other.text()) == (200, await first.text())


async def test_the_page_is_sent_compressed(client: Client) -> None:
    """A client that accepts gzip gets the precompressed file, with its own type."""
    small = await client.get("/assets/b.js", headers={"Accept-Encoding": "gzip"})
    assert small.headers["Content-Encoding"] == "gzip"
    assert int(small.headers["Content-Length"]) < 100
    assert "javascript" in small.headers["Content-Type"]
    assert await small.text() == "2" * 1000


async def test_beside_sound_on_a_thin_link_files_go_out_in_small_pieces(
    client: Client, room: FakeRoom
) -> None:
    """Each piece is counted; the page itself, needed at once, is not paced."""
    room.file_waits_s = 0.02
    large = await client.get("/assets/b.js", headers={"Accept-Encoding": "identity"})
    assert await large.text() == "2" * 1000
    assert room.pieces == 5
    await client.get("/")
    assert room.pieces == 5


async def test_the_page_is_served(client: Client) -> None:
    """The page must be revalidated each time, its hashed assets never."""
    page = await client.get("/")
    asset = await client.get("/assets/a.js")
    assert (page.status, asset.status) == (200, 200)
    assert page.headers["Cache-Control"] == "no-cache"
    assert "immutable" in asset.headers["Cache-Control"]


async def test_health_status_and_ice_servers(client: Client, access: Access) -> None:
    """Each answers as JSON; health identifies the run of the server."""
    first, again = [await (await client.get("/healthz")).json() for _ in range(2)]
    assert first == again == {"ok": True, "run": first["run"]}
    assert len(first["run"]) == 16
    await become_host(client, access)
    assert await (await client.get("/api/status")).json() == {"version": "x"}
    assert await (await client.get("/api/ice")).json() == {
        "iceServers": [{"urls": "stun:stun.example:3478"}],
        "relayOnly": False,
        "wantsCandidates": False,
    }


async def test_parts_that_are_not_ready_are_named(client: Client, room: FakeRoom) -> None:
    """A load balancer gets a status and the parts' names; the process still counts as healthy."""
    ready = await client.get("/readyz")
    assert (ready.status, await ready.json()) == (200, {"ready": True, "reasons": []})
    room.missing = {"robot": "No answer."}
    ready = await client.get("/readyz")
    assert (ready.status, await ready.json()) == (503, {"ready": False, "reasons": ["robot"]})
    assert (await client.get("/healthz")).status == 200


async def test_an_offer_is_answered(client: Client, room: FakeRoom) -> None:
    """A good offer gets an answer, and the room learns whose it is."""
    response = await client.post("/api/offer", json=GOOD)
    assert await response.json() == {"sdp": "v=0 answer"}
    assert room.offers == [("12345678-abcd", "v=0")]


@pytest.mark.parametrize("path", ["/api/offer", "/api/embed"])
async def test_a_page_that_cannot_offer_answers_ours(
    client: Client, room: FakeRoom, path: str
) -> None:
    """It asks with an empty description, and sends its answer the same way."""
    response = await client.post(path, json=GOOD | {"sdp": ""})
    assert await response.json() == {"sdp": "v=0 offer"}
    response = await client.post(path, json=GOOD | {"answers": True})
    assert await response.json() == {"sdp": ""}
    assert room.accepted == [(room.offers[0][0], "v=0")]
    assert room.visitors[0].identity == room.visitors[1].identity


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 400),
        (b"hello", 400),
        (b"[]", 400),
        (b"\xff\xfe", 400),
        (json.dumps(GOOD | {"client": "x"}).encode(), 400),
        (json.dumps(GOOD | {"client": "../../../etc"}).encode(), 400),
        (json.dumps(GOOD | {"more": 1}).encode(), 400),
        (json.dumps(GOOD | {"sdp": "v" * 40_000}).encode(), 400),
        (json.dumps(GOOD | {"sdp": "v" * 70_000}).encode(), 413),
    ],
)
@pytest.mark.parametrize("packs", [bytes, gzip.compress])
async def test_bad_offers_get_a_sentence(
    client: Client,
    room: FakeRoom,
    body: bytes,
    status: int,
    packs: Callable[[bytes], bytes],
) -> None:
    """A bad body, compressed or not, is refused with a sentence and never reaches the room."""
    headers = PACKED if packs is gzip.compress else {}
    response = await client.post("/api/offer", data=packs(body), headers=headers)
    assert response.status == status
    assert len((await response.json())["error"]) > 5
    assert not room.offers


@pytest.mark.parametrize(
    "path", ["/api/host", "/api/enter", "/api/queue", "/api/seat", "/api/stop", "/api/release"]
)
@pytest.mark.parametrize("packs", [bytes, gzip.compress])
async def test_every_body_but_an_offer_is_small(
    client: Client, path: str, packs: Callable[[bytes], bytes]
) -> None:
    """It has at most two kilobytes, compressed or not."""
    await client.post("/api/offer", json=GOOD)
    headers = PACKED if packs is gzip.compress else {}
    for size, status in ((2048, 400), (2049, 413)):
        data = packs(b" " * size)
        assert (await client.post(path, data=data, headers=headers)).status == status


async def test_an_offer_may_be_compressed(client: Client, room: FakeRoom) -> None:
    """On a slow link the page sends it in gzip, and the answer is in gzip, too."""
    packed = gzip.compress(json.dumps(GOOD).encode())
    headers = PACKED | {"Accept-Encoding": "gzip"}
    response = await client.post("/api/offer", data=packed, headers=headers)
    assert response.headers["Content-Encoding"] == "gzip"
    assert await response.json() == {"sdp": "v=0 answer"}
    assert room.offers == [("12345678-abcd", "v=0")]


@pytest.mark.parametrize(
    ("body", "status"),
    [
        pytest.param(lambda: gzip.compress(json.dumps(GOOD).encode())[:-9], 400, id="cut off"),
        pytest.param(lambda: json.dumps(GOOD).encode(), 400, id="no gzip"),
        pytest.param(lambda: gzip.compress(b" " * 6_000_000), 413, id="vast"),
    ],
)
async def test_an_offer_that_does_not_unpack_gets_a_sentence(
    client: Client, room: FakeRoom, body: Callable[[], bytes], status: int
) -> None:
    """One that is cut off, is no gzip, or would fill the memory is refused."""
    response = await client.post("/api/offer", data=body(), headers=PACKED)
    assert response.status == status
    assert len((await response.json())["error"]) > 5
    assert not room.offers


@pytest.mark.parametrize(
    ("error", "status", "says"),
    [
        (SignallingError("no picture"), 400, "no picture"),
        (FullError("all taken"), 503, "all taken"),
        (RuntimeError("secret"), 500, "see its log"),
    ],
)
async def test_errors_become_a_status_and_a_sentence(
    client: Client, room: FakeRoom, error: Exception, status: int, says: str
) -> None:
    """Our errors show their sentence; any other reveals nothing internal."""
    room.error = error
    response = await client.post("/api/offer", json=GOOD)
    assert response.status == status
    assert says in (await response.json())["error"]


async def test_an_offer_without_a_place_gets_a_seat(client: Client, room: FakeRoom) -> None:
    """A seat replaces only a place: a tab too many is too many in a LiveKit room as well."""
    tab = GOOD["client"]
    room.error = NoPlaceError("all taken")
    response = await client.post("/api/offer", json=GOOD)
    assert response.status == 200
    assert await response.json() == {"what": f"seat of {tab}", "is_somebody": True}
    room.full = FullError("All places to watch are taken")
    response = await client.post("/api/offer", json=GOOD)
    assert (response.status, response.headers["Retry-After"]) == (503, "1")
    assert (await response.json())["error"] == "All places to watch are taken"
    room.full, room.error = None, FullError("too many tabs")
    response = await client.post("/api/offer", json=GOOD)
    assert (await response.json())["error"] == "too many tabs"


@pytest.mark.parametrize(
    ("path", "body", "what"),
    [
        ("/api/seat", {}, "seat of {}"),
        ("/api/queue", {"wants": "join", "name": "Eve"}, "join of {}Eve"),
        *at_length(("/api/queue", {"wants": "stay"}, "stay of {}")),
    ],
)
async def test_viewers_in_a_room_use_http(
    client: Client, clock: TurnedClock, path: str, body: dict[str, str], what: str
) -> None:
    """A cookie identifies them, and they may ask ten times as often as others connect."""
    asked = body | {"client": GOOD["client"]}
    headers = {"X-Forwarded-For": "192.0.2.7"}
    response = await client.post(path, json=asked, headers=headers)
    assert await response.json() == {"what": what.format(GOOD["client"]), "is_somebody": True}
    for wrong in (body, asked | {"client": "x"}, asked | {"wants": "everything"}):
        assert (await client.post(path, json=wrong, headers=headers)).status == 400
    answers = [(await client.post(path, json=asked, headers=headers)).status for _ in range(400)]
    assert answers == [200] * 396 + [429] * 4
    clock.time_s += 0.1
    assert (await client.post(path, json=asked, headers=headers)).status == 200


async def test_a_page_that_is_closed_leaves_its_seat(client: Client, room: FakeRoom) -> None:
    """It names its tab; a cookie identifies its browser."""
    response = await client.post("/api/seat", json={"client": GOOD["client"], "leaves": True})
    assert (response.status, await response.json()) == (200, {})
    ((identity, tab),) = room.left
    assert identity
    assert tab == GOOD["client"]


async def test_one_address_does_not_take_the_servers_time(
    client: Client, room: FakeRoom, clock: TurnedClock, access: Access
) -> None:
    """After a burst, strangers at an address get two offers a second; others are served."""

    async def offers(address: str, count: int) -> list[int]:
        headers = {"X-Forwarded-For": address}
        found = []
        for _ in range(count):
            client.session.cookie_jar.clear()
            found.append((await client.post("/api/offer", json=GOOD, headers=headers)).status)
        return found

    assert await offers("192.0.2.7", 45) == [200] * 40 + [429] * 5
    assert len(room.offers) == 40
    refused = await client.post(
        "/api/offer", data=b"not even JSON", headers={"X-Forwarded-For": "8.8.8.8, 192.0.2.7"}
    )
    assert (refused.status, refused.headers["Retry-After"]) == (429, "1")
    assert "Too many connections" in (await refused.json())["error"]
    assert await offers("192.0.2.8", 1) == [200]
    clock.time_s += 1.0
    assert await offers("192.0.2.7", 3) == [200, 200, 429]
    await become_host(client, access)
    host = [await client.post("/api/offer", json=GOOD) for _ in range(45)]
    assert [one.status for one in host] == [200] * 45, "the host always gets in"
    assert (await host[0].json())["host"], "the host's page says more about what fails"


async def test_neighbours_do_not_lock_out_known_people(
    client: Client, room: FakeRoom, clock: TurnedClock
) -> None:
    """Everybody in the room has a bucket of their own, by cookie; others are strangers."""
    headers = {"X-Forwarded-For": "192.0.2.7"}

    async def offer(**more: str) -> int:
        return (await client.post("/api/offer", json=GOOD, headers=headers | more)).status

    assert await offer() == 200
    known = (
        f"wax-id={client.session.cookie_jar.filter_cookies(client.make_url('/'))['wax-id'].value}"
    )
    found = []
    for _ in range(60):
        client.session.cookie_jar.clear()
        found.append(await offer())
    assert found[-20:] == [429] * 20
    client.session.cookie_jar.clear()
    assert [await offer(Cookie=known) for _ in range(10)] == [200] * 10
    assert await offer(Cookie=known) == 429, "a reserve can be used up"
    clock.time_s += 1.0
    assert await offer(Cookie=known) == 200
    assert await offer(Cookie="wax-id=made.up") in (200, 429)


async def test_the_right_secret_works_whatever_neighbours_try(
    client: Client, access: Access
) -> None:
    """A link's secret works after any number of failed tries from the same address."""
    tries = [(await client.post("/api/host", json={"secret": "x" * 32})).status for _ in range(20)]
    assert tries == [403] * 10 + [429] * 10
    assert (await client.post("/api/host", json={"secret": access.new_host_link()})).status == 200


async def test_under_https_cookies_cannot_be_planted(client: Client, room: FakeRoom) -> None:
    """They have the prefix there; an old identity gets it with the next answer, and stays."""
    https = {"X-Forwarded-Proto": "https", "X-Forwarded-For": "192.0.2.7"}
    old = await client.post("/api/offer", json=GOOD, headers=https | {"X-Forwarded-Proto": "http"})
    value = old.cookies["wax-id"].value
    client.session.cookie_jar.clear()
    shown = https | {"Cookie": f"wax-id={value}"}
    renamed = await client.post("/api/offer", json=GOOD, headers=shown)
    assert renamed.cookies["__Host-wax-id"].value == value
    assert room.visitors[0].identity == room.visitors[1].identity
    client.session.cookie_jar.clear()
    new = await client.post("/api/offer", json=GOOD, headers=https)
    given = new.cookies["__Host-wax-id"]
    assert (given["secure"], given["path"], given["domain"]) == (True, "/", "")
    client.session.cookie_jar.clear()
    planted = https | {"Cookie": f"wax-id={given.value}"}
    await client.post("/api/offer", json=GOOD, headers=planted)
    again = https | {"Cookie": f"__Host-wax-id={given.value}"}
    await client.post("/api/offer", json=GOOD, headers=again)
    assert room.visitors[2].identity == room.visitors[4].identity != room.visitors[3].identity


async def test_the_page_is_rendered_once_for_each_name(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Strangers' most frequent request reads no file, hashes and compresses nothing."""
    first = await client.get("/")
    await first.read()
    monkeypatch.setattr(BrandedPage, "html", None)
    again = await client.get("/")
    assert (again.status, await again.read()) == (200, await first.read())
    same = await client.get("/", headers={"If-None-Match": again.headers["ETag"]})
    assert (same.status, await same.read()) == (304, b"")


@pytest.mark.parametrize("path", ["/", "/assets/b.js", "/open.ics", "/?view=embed", "/api/status"])
async def test_a_head_request_gets_the_headers_of_a_get(client: Client, path: str) -> None:
    """Sites that make link previews send it first; it needs the same permission."""
    got, asked = await client.get(path), await client.head(path)
    policy = "Content-Security-Policy"
    assert (asked.status, asked.headers[policy]) == (got.status, got.headers[policy])
    assert await asked.read() == b""
    assert (got.status == 403) == (path == "/api/status")


async def test_a_link_keeps_working_whatever_sites_add_to_it(client: Client) -> None:
    """A click's ID of 300 letters is accepted; a longer query than browsers send is refused."""
    clicked = "fbclid=" + "a" * 300
    assert (await client.get(f"/?{clicked}")).status == 200
    assert (await client.get(f"/?{'a' * 9000}")).status == 400


async def test_an_embed_is_answered_whatever_its_cookies_are(
    client: Client, room: FakeRoom, access: Access
) -> None:
    """No cookie counts, not even the host's; it gets no cookie, and no seat in a room."""
    await client.post("/api/offer", json=GOOD)
    await become_host(client, access)
    response = await client.post("/api/embed", json=GOOD)
    assert await response.json() == {"sdp": "v=0 answer"}
    assert "Set-Cookie" not in response.headers
    watching = room.visitors[-1]
    assert watching == Visitor(watching.identity, "127.0.0.1", is_embed=True)
    assert access.identity_of(Shown(watching.identity)) is None
    room.error = NoPlaceError("All are taken.", retry_after_s=60)
    full = await client.post("/api/embed", json=GOOD)
    assert (full.status, full.headers["Retry-After"]) == (503, "60")
    assert (await client.post("/api/embed", json=GOOD | {"host": True})).status == 400


async def test_an_embed_is_identified_by_a_secret_that_is_not_kept(
    client: Client, room: FakeRoom
) -> None:
    """It can reconnect by it; what the room knows, and so may record, identifies nobody."""
    for secret in (GOOD["client"], GOOD["client"], "12345678-dcba"):
        await client.post("/api/embed", json=GOOD | {"client": secret})
    first, again, other = (one.identity for one in room.visitors)
    assert first == again != other
    assert GOOD["client"] not in str((room.visitors, room.offers))
    await client.post("/api/embed", json=GOOD | {"client": first.removeprefix("embed ")})
    assert room.visitors[-1].identity != first


async def test_only_the_view_for_frames_may_be_framed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the configured sites may frame it; any other answer, only our own page."""
    sites = ["https://museum.example", "http://localhost:3000"]
    settings = PageSettings(embed_on=sites)
    page = "/?url=http%3A%2F%2F127.0.0.1%3A{}%2F"
    async with await _served(settings, tmp_path, monkeypatch) as client:
        about = page.format(client.port).replace("/?", "/oembed?")
        for path in ("/", "/?view=big-screen", "/?view=embed2", "/?embed", about, "/page.css"):
            answer = await client.get(path)
            assert answer.status == 200, path
            policy = answer.headers["Content-Security-Policy"]
            assert policy.endswith("frame-ancestors 'self'"), path
            assert 'data-view="embed"' not in await answer.text()
        assert (await client.get(about + "&a" * 500)).status == 404, "it is parsed as a whole"
        for path in ("/?view=embed", "/?view=%65mbed&x=1"):
            frame = await client.get(path)
            assert 'data-view="embed"' in await frame.text()
            headers = {"If-None-Match": frame.headers["ETag"]}
            for answer in (frame, await client.get(path, headers=headers)):
                policy = answer.headers["Content-Security-Policy"]
                assert policy.endswith(f"; frame-ancestors 'self' {' '.join(sites)}")
                assert "Set-Cookie" not in answer.headers
    shutil.rmtree(tmp_path / "dist")
    async with await _served(PageSettings(), tmp_path, monkeypatch) as client:
        frame = await client.get("/?view=embed")
        assert frame.headers["Content-Security-Policy"].endswith("frame-ancestors 'self'")
        assert (await client.get(page.format(client.port).replace("/?", "/oembed?"))).status == 404


async def test_a_links_parameters_are_not_parsed(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other sites add to a link; parsing 8 KB would take milliseconds in one step."""
    monkeypatch.setattr(BaseRequest, "query", property(lambda _: pytest.fail("parsed")))
    frame = await client.get("/?" + "a&" * 3900 + "view=embed")
    assert frame.headers["Cross-Origin-Resource-Policy"] == "cross-origin"


async def test_a_cross_origin_isolated_site_shows_the_frame(client: Client) -> None:
    """Such a site needs two headers in the frame, and one in its workers; the page has neither."""
    frame, worker, page = [
        (await client.get(path)).headers for path in ("/?view=embed", "/assets/b.js", "/")
    ]
    assert frame["Cross-Origin-Resource-Policy"] == "cross-origin"
    embedder = "Cross-Origin-Embedder-Policy"
    assert frame[embedder] == worker[embedder] == "require-corp"
    assert worker["Cross-Origin-Resource-Policy"] == "same-origin"
    assert page["Cross-Origin-Resource-Policy"] == "same-origin"
    assert embedder not in page


async def test_unknown_paths_and_methods(client: Client) -> None:
    """No file outside the page is served, and a wrong method gets a sentence."""
    for path in ("/nothing", "/../secret", "/%2e%2e/secret", "/assets"):
        assert (await client.get(path)).status in (403, 404)
    response = await client.put("/api/offer")
    assert response.status == 405
    assert (await response.json())["error"]
    # A proxy has left its path in, and a person reads the answer: it is a page.
    below = await client.get("/robot/", headers={"Accept": "text/html,*/*;q=0.8"})
    assert (below.status, below.content_type) == (404, "text/html")
    assert "has to take the path away" in await below.text()


def test_a_page_that_was_not_built_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, room: FakeRoom
) -> None:
    """Without the built page the server does not start, and says what to type."""
    monkeypatch.setattr(routes, "PAGE", tmp_path)
    made = make_routes(room)
    with pytest.raises(StartError, match="make run"):
        made.application()


async def test_stop_and_release_by_http(client: Client, room: FakeRoom) -> None:
    """Any viewer can stop without naming their tab; a release says which stop."""
    await client.post("/api/offer", json=GOOD)
    response = await client.post("/api/stop", json={})
    assert (response.status, await response.json()) == (200, {"stop": 7})
    await client.post("/api/stop", json={"client": "12345678-abcd", "press": 5})
    await client.post("/api/release", json={"client": "12345678-abcd", "stop": 7})
    tab = "12345678-abcd"
    assert room.stops == [(None, None, False), (tab, 5, False), (tab, 7, False)]
    room.error = ForbiddenError("not you")
    refused = await client.post("/api/release", json={"stop": 7})
    assert (refused.status, await refused.json()) == (
        403,
        {"error": "not you", "sentence": {"code": "says", "values": {"text": "not you"}}},
    )
    assert (await client.post("/api/release", json={"client": "12345678-abcd"})).status == 400
    assert (await client.post("/api/release", json={"stop": "7"})).status == 400


HOSTS = [
    ("GET", "/api/status"),
    ("POST", "/api/proof"),
    ("GET", "/api/proof"),
    ("GET", "/api/proof/record"),
]


async def test_the_host_is_known_by_a_secret(
    client: Client, room: FakeRoom, lent: Lent, access: Access
) -> None:
    """Even this machine's users are strangers until they send it; from then on, a cookie counts."""
    for method, path in HOSTS:
        response = await client.request(method, path, json={"lifted": True})
        assert response.status == 403
        assert (await response.json())["error"] == "Only the host can do that."
    assert (await client.post("/api/host", json={"secret": "guessed"})).status == 403
    assert lent.started == 0
    await client.post("/api/offer", json=GOOD)
    await become_host(client, access)
    await client.post("/api/offer", json=GOOD)
    assert [one.is_host for one in room.visitors] == [False, True]
    assert (await client.get("/api/status")).status == 200


async def test_cookies_are_for_our_page_only(client: Client, access: Access) -> None:
    """Scripts and other sites cannot use them; the page itself sets none, only its requests do."""
    assert "Set-Cookie" not in (await client.get("/")).headers
    offered = (await client.post("/api/offer", json=GOOD)).headers["Set-Cookie"]
    became = await client.post("/api/host", json={"secret": access.new_host_link()})
    for name, cookie in (("wax-id", offered), ("wax-host", became.headers["Set-Cookie"])):
        said = {part.strip() for part in cookie.split(";")[1:]}
        assert cookie.startswith(f"{name}=")
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= said
        assert "Secure" not in said
    headers = {"X-Forwarded-For": "203.0.113.1", "X-Forwarded-Proto": "https"}
    secret = access.new_host_link()
    secure = await client.post("/api/host", json={"secret": secret}, headers=headers)
    assert "Secure" in secure.headers["Set-Cookie"]


async def test_a_browser_keeps_its_identity(client: Client, room: FakeRoom) -> None:
    """Its first offer gets one; a browser that sends none is somebody new."""
    for _ in range(2):
        await client.post("/api/offer", json=GOOD)
    client.session.cookie_jar.clear()
    await client.post("/api/offer", json=GOOD)
    first, again, other = (one.identity for one in room.visitors)
    assert first == again != other != ""


async def test_the_hosts_cookie_rotates(
    client: Client, room: FakeRoom, access: Access, clock: TurnedClock
) -> None:
    """Each offer gets a new one; the previous one stays valid for a minute."""
    await become_host(client, access)
    old = client.session.cookie_jar.filter_cookies(client.make_url("/"))["wax-host"].value
    await client.post("/api/offer", json=GOOD)
    new = client.session.cookie_jar.filter_cookies(client.make_url("/"))["wax-host"].value
    assert new != old
    await client.post("/api/offer", json=GOOD)
    assert [one.is_host for one in room.visitors] == [True, True]


async def test_an_invitation_by_http(client: Client, room: FakeRoom, access: Access) -> None:
    """The page posts the token, which stays in no URL; from then on the browser is invited."""
    token, _ = access.invite("queue", uses=1, valid_s=600)
    entered = await client.post("/api/enter", json={"token": token})
    assert (entered.status, await entered.json()) == (200, {"purpose": "queue"})
    await client.post("/api/offer", json=GOOD)
    assert room.visitors[0].invited_to == "queue"
    client.session.cookie_jar.clear()
    used = await client.post("/api/enter", json={"token": token})
    assert (used.status, "used up" in (await used.json())["error"]) == (403, True)


async def test_secrets_cannot_be_tried_out(client: Client) -> None:
    """After a few failed tries, an address has to wait."""
    codes = [(await client.post("/api/host", json={"secret": "x"})).status for _ in range(12)]
    assert codes == [403] * 10 + [429] * 2


async def test_a_refused_visitor_learns_when_it_opens(client: Client, access: Access) -> None:
    """The page is told not to retry by itself, and gets no relay meanwhile."""
    access.close(True)
    response = await client.get("/api/ice")
    told = await response.json()
    assert response.status == 403
    assert told == {
        "error": "The robot is closed.",
        "sentence": {"code": "door.closed"},
        "ended": True,
        "openings": [],
    }


async def test_strangers_stop_nothing(client: Client, room: FakeRoom) -> None:
    """Only people in the room can press Stop by HTTP."""
    refused = await client.post("/api/stop", json={})
    assert (refused.status, room.stops) == (403, [])
    await client.post("/api/offer", json=GOOD)
    assert (await client.post("/api/stop", json={})).status == 200


async def test_a_page_without_cookies_stops_by_its_tab(client: Client, room: FakeRoom) -> None:
    """It can only stop, and a browser with a cookie cannot use another's tab."""
    await client.post("/api/offer", json=GOOD)
    client.session.cookie_jar.clear()
    known, other = {"WAX-Tab": GOOD["client"]}, {"WAX-Tab": "12345678-none"}
    assert (await client.post("/api/stop", json={}, headers=other)).status == 403
    assert (await client.post("/api/stop", json={}, headers=known)).status == 200
    assert (await client.post("/api/release", json={"stop": 7}, headers=known)).status == 403
    await client.post("/api/queue", json={"client": "12345678-efgh", "wants": "here"})
    assert (await client.post("/api/stop", json={}, headers=known)).status == 403
    assert room.stops == [(None, None, False)]


async def test_the_host_proves_the_stop(client: Client, lent: Lent, access: Access) -> None:
    """The proof starts only when the host confirms that the wheels are off the floor."""
    await become_host(client, access)
    for body in ({}, {"lifted": False}, {"lifted": "yes"}):
        assert (await client.post("/api/proof", json=body)).status == 400
    assert lent.started == 0
    response = await client.post("/api/proof", json={"lifted": True})
    assert (response.status, lent.started) == (202, 1)
    assert (await (await client.get("/api/proof")).json())["state"] == "never"
    assert (await client.get("/api/proof/record")).status == 403
    lent.page = "<style>p { color: red }</style>"
    response = await client.get("/api/proof/record")
    assert (response.content_type, await response.text()) == ("text/html", lent.page)
    policy = response.headers["Content-Security-Policy"]
    digest = base64.b64encode(hashlib.sha256(b"p { color: red }").digest()).decode()
    assert policy.startswith(f"default-src 'none'; style-src 'sha256-{digest}';"), (
        "its style counts"
    )
