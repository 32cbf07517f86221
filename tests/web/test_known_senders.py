"""Forged identities over a real connection: only a trusted proxy says who somebody is."""

from __future__ import annotations

import asyncio
import json
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
from tests.turned_clock import TurnedClock
from tests.visitors import make_access
from tests.web.rig import make_routes

from wax.config.access import AccessSettings
from wax.config.page import PageSettings
from wax.config.proxy import ProxySettings
from wax.config.server import ServerSettings
from wax.records.records import Records
from wax.web import routes
from wax.web.branding import BrandedPage
from wax.web.entrance import Entrance
from wax.web.guards import Guards

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.access.access import Access
    from wax.access.admission import Visitor
    from wax.access.permissions import Role

PROXY = ProxySettings(person="Remote-User", groups="Remote-Groups", host=["staff"])
HERE = ["127.0.0.1"]
ELSEWHERE = ["192.0.2.1"]
ALICE = "Remote-User: alice\r\n"
STAFF = "Remote-User: mallory\r\nRemote-Groups: staff\r\n"


class Noting:
    """A room that notes who asks, and lets everybody in whom admission lets in."""

    def __init__(self, access: Access) -> None:
        self.access = access
        self.asked: list[Visitor] = []
        self.payers: list[tuple[str, bool] | None] = []

    def role_of(self, visitor: Visitor) -> Role:
        if visitor.is_host:
            return "host"
        return (
            "observer" if visitor.identity in {one.identity for one in self.asked} else "stranger"
        )

    def renew(self, visitor: Visitor) -> None: ...

    def by_tab(self, visitor: Visitor, tab: str) -> Visitor:
        return visitor

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        self.access.admit(visitor)
        self.asked.append(visitor)
        return "v=0 answer"


@pytest.fixture(autouse=True)
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the routes a page, whether or not ours is built."""
    (tmp_path / "index.html").write_text("<!doctype html>")
    monkeypatch.setattr(routes, "PAGE", tmp_path)


@asynccontextmanager
async def served(trusted: list[str]) -> AsyncIterator[tuple[int, Noting]]:
    clock = TurnedClock()
    access = make_access(Records(clock), clock, AccessSettings(proxy=PROXY))
    server = ServerSettings(host="127.0.0.1", port=0, trusted_proxies=trusted)
    room = Noting(access)
    made = make_routes(room, clock=clock, access=access, guards=Guards(server, clock))

    def who(*asking: Any) -> tuple[str, bool] | None:
        room.payers.append(made.who(*asking))
        return room.payers[-1]

    entrance = Entrance(made.application(), server, clock, who=who, asked=access.asked)
    await entrance.open()
    try:
        yield entrance.port, room
    finally:
        await entrance.close()


def offer(headers: str, *, last: bool = False) -> bytes:
    body = json.dumps({"sdp": "v=0", "client": "12345678-abcd"})
    end = "Connection: close\r\n" if last else ""
    return (
        f"POST /api/offer HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n"
        f"{end}{headers}\r\n{body}"
    ).encode(errors="surrogateescape")


async def answers(port: int, *requests: bytes) -> list[int]:
    """Send requests in one piece over one connection; return the statuses of the answers."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(b"".join(requests))
    async with asyncio.timeout(10.0):
        said = await reader.read()
    writer.close()
    return [int(one) for one in re.findall(rb"HTTP/1\.1 (\d+)", said)]


@pytest.mark.parametrize(
    ("trusted", "headers", "status"),
    [
        (HERE, ALICE, 200),
        (HERE, "REMOTE-USER: alice\r\n", 200),
        (HERE, "", 403),
        (HERE, "Remote-User:\r\n", 403),
        (HERE, "Remote_User: alice\r\n", 403),
        (HERE, ALICE + "Remote-User: mallory\r\n", 403),
        (HERE, ALICE + "remote-user: alice\r\n", 403),
        (HERE, "Remote-User: alice, mallory\r\n", 403),
        (HERE, "Remote-User: ali\tce\r\n", 403),
        (HERE, "Remote-User: ali\udcffce\r\n", 403),
        (HERE, f"Remote-User: {'a' * 300}\r\n", 403),
        (HERE, ALICE + "Remote-Groups: a\r\nRemote-Groups: staff\r\n", 403),
        (HERE, "Cookie: Remote-User=alice\r\nX-Remote-User: alice\r\n", 403),
        (ELSEWHERE, ALICE, 403),
        (ELSEWHERE, STAFF, 403),
        (ELSEWHERE, "X-Forwarded-For: 192.0.2.1\r\n" + ALICE, 403),
        (ELSEWHERE, "Forwarded: for=192.0.2.1\r\n" + STAFF, 403),
        ([], ALICE, 403),
    ],
)
async def test_nobody_is_believed_but_the_proxy(
    trusted: list[str], headers: str, status: int
) -> None:
    """A name counts once, by its own header, from a trusted proxy itself; nothing else lets in."""
    async with served(trusted) as (port, room):
        assert await answers(port, offer(headers, last=True)) == [status]
    assert len(room.asked) == (status == 200)
    assert not any(one.is_host for one in room.asked)
    assert set(room.payers) <= {None}


async def test_each_request_on_a_connection_is_judged_anew() -> None:
    """Of requests in one piece, each is its own sender's, and one that names nobody is refused."""
    async with served(HERE) as (port, room):
        sent = [offer(ALICE), offer(""), offer("Remote-User: bob\r\n"), offer(STAFF), offer("")]
        sent.append(offer(ALICE, last=True))
        assert await answers(port, *sent) == [200, 403, 200, 200, 403, 200]
    alice, bob, mallory, again = room.asked
    assert len({alice.identity, bob.identity, mallory.identity}) == 3
    assert again.identity == alice.identity
    assert [one.is_host for one in room.asked] == [False, False, True, False]
    assert room.payers[-1] == (alice.identity, False)


async def test_only_who_is_let_in_asks_for_anything() -> None:
    """Every other way in (the relay's secret, an invitation, a frame) is closed to the unnamed."""
    bodies = {
        "POST /api/embed": {"sdp": "v=0", "client": "12345678-abcd"},
        "POST /api/enter": {"token": "x"},
        "POST /api/seat": {"client": "12345678-abcd"},
        "POST /api/queue": {"client": "12345678-abcd", "wants": "join"},
        "GET /api/ice": None,
        "GET /api/status": None,
        "POST /api/stop": {"client": "12345678-abcd"},
    }
    for trusted, headers in ((HERE, ""), (ELSEWHERE, STAFF)):
        async with served(trusted) as (port, _):
            for route, body in bodies.items():
                text = "" if body is None else json.dumps(body)
                head = f"{route} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}"
                request = f"{head}Content-Length: {len(text)}\r\n\r\n{text}".encode()
                assert await answers(port, request) == [403], route


def test_only_a_page_behind_a_proxy_loads_what_shows_that_one_is_signed_in() -> None:
    """With `[access.proxy]` the page has one script more; without it, not a byte more."""
    built = "<html lang='en'><head></head></html>"
    plain = BrandedPage(PageSettings()).html(built, "")
    known = BrandedPage(PageSettings(), is_for_known=True)
    script = '<script src="present.js" defer></script>'
    assert script not in plain
    assert known.html(built, "").replace(f"  {script}\n  ", "") == plain
    assert script not in known.html(built, "", is_embed=True)
