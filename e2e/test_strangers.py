"""Strangers at the door: what they may not, how the host gets rid of them, and who stays.

A proxy that is trusted says for everybody who asks where they come from, since the address of
this machine itself is never banned.
"""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

import aiohttp
import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.robot import moves, stands_still
from e2e.harness.wait import eventually
from wax.access.admission import BANNED, LOCKED, TOO_MANY_TABS
from wax.access.keyring import SECRET_BYTES, Keyring
from wax.access.secret_file import FILE
from wax.client import Client, Operator
from wax.clock import SystemClock
from wax.control.reasons import Refusal
from wax.errors import SignallingError
from wax.session.stop_presses import KNOWN_S, MUTED, TOO_OFTEN

if TYPE_CHECKING:
    from asyncio import StreamReader, StreamWriter
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

    Come = Callable[..., Awaitable[Operator]]

pytestmark = pytest.mark.timeout(90)

STOPS_A_MINUTE: Final = 3
HERS: Final = "192.0.2.7"
TROLLS: Final = "192.0.2.66"
"""Addresses for documentation (RFC 5737)."""
LUMA: Final = """() => {
    const context = new OffscreenCanvas(16, 16).getContext("2d");
    context.drawImage(document.querySelector("video"), 0, 0, 16, 16);
    const { data } = context.getImageData(0, 0, 16, 16);
    return Math.max(...data.filter((_, index) => index % 4 !== 3));
}"""
"""The brightest of what the page's picture shows, 0…255."""
BLACK: Final = 16
SILENT: Final = 0.001


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(
        server='trusted_proxies = ["127.0.0.1"]',
        stop=f"max_per_minute = {STOPS_A_MINUTE}\nmax_per_minute_per_address = 1000",
        turns=toml.BRIEF_GRACE,
        log='level = "debug"',
    )
    async with serve(tmp_path_factory.mktemp("strangers"), settings) as running:
        yield running


@pytest_asyncio.fixture(loop_scope="session")
async def come(server: Server) -> AsyncIterator[Come]:
    """Let somebody in; they leave at the end of the test."""
    async with AsyncExitStack() as leaving:

        async def one(address: str = HERS, *, url: str = server.url, **options: Any) -> Operator:
            client = Operator(url, headers=_from(address), **options)
            return await leaving.enter_async_context(client)

        yield one


@pytest_asyncio.fixture(loop_scope="session")
async def host(server: Server, come: Come) -> Operator:
    return await come(cookies=await server.host_cookies())


async def test_the_status_is_the_hosts(server: Server, host: Operator, come: Come) -> None:
    """No stranger, observer or operator reads the status or the proof; the host does."""
    observer, operator = await come(), await come()
    await operator.join()
    for path in ("/api/status", "/api/proof"):
        for guest in (None, observer.cookies, operator.cookies):
            assert (await server.get(path, guest))[0] == 403
        assert (await server.get(path, host.cookies))[0] == 200


async def test_a_forwarded_port_makes_nobody_host(server: Server, come: Come) -> None:
    """Whoever comes from this machine itself, through a forwarded port, is one of the guests."""
    async with forwarded(server.port) as url, aiohttp.ClientSession() as http:
        for path in ("/api/status", "/api/proof", "/api/proof/record"):
            async with http.get(url + path) as response:
                assert response.status == 403
        async with http.post(f"{url}/api/proof", json={"lifted": True}) as response:
            assert response.status == 403
        async with http.post(f"{url}/api/host", json={"secret": "a" * 32}) as response:
            assert response.status == 403
        guest = await come(url=url)
        assert guest.newest("hello")["is_host"] is False


async def test_stop_is_for_those_who_watch(server: Server, host: Operator, come: Come) -> None:
    """Nobody stops from outside the room; an observer does, as often as they may, until muted."""
    async with (
        aiohttp.ClientSession(headers=_from(HERS)) as http,
        http.post(f"{server.url}/api/stop", json={}) as response,
    ):
        assert response.status == 403
    assert host.stopped is None
    observer, other = await come(), await come()
    first = await observer.press_stop()
    assert await host.until(lambda: host.stopped == first)
    for _ in range(STOPS_A_MINUTE - 1):
        assert await observer.press_stop() == first
    assert str(TOO_OFTEN) in await refusal(observer.press_stop())
    assert "Only the operator or the host" in await refusal(
        observer.post("/api/release", {"stop": first})
    )
    host.release(first)
    assert await host.until(lambda: host.stopped is None)

    host.say(type="mute", viewer=other.viewer, muted=True)

    async def is_refused() -> bool:
        # Nothing says which of two peers' messages comes first.
        other.say(type="stop")
        return other.newest("notice").get("text") == MUTED.wire()

    await eventually(is_refused, "a muted viewer is told so")
    if await host.until(lambda: host.stopped is not None, 1.0):  # one came before the mute
        host.release(host.stopped or 0)
    assert str(MUTED) in await refusal(other.press_stop())
    assert await host.until(lambda: host.stopped is None)


@pytest.mark.full
async def test_a_flood_of_browsers_stops_no_more_than_its_address_may(
    serve: Serve, tmp_path: Path
) -> None:
    """New ones press once each; whoever was there before is heard all the same, and the host sees
    where it comes from, ignores it, and who drives goes on.
    """
    settings = toml.card_with(stop="max_per_minute_per_address = 4")
    async with AsyncExitStack() as leaving, serve(tmp_path, settings) as server:

        async def one(cookies: aiohttp.CookieJar | None = None) -> Operator:
            return await leaving.enter_async_context(Operator(server.url, cookies=cookies))

        host, known = await one(await server.host_cookies()), await one()
        await asyncio.sleep(KNOWN_S + 0.5)
        flood = [await one() for _ in range(5)]
        for new in flood[:2]:
            await new.press_stop()
        for new in flood[2:]:
            assert str(TOO_OFTEN) in await refusal(new.press_stop())
        await known.press_stop()
        assert await host.until(lambda: bool(host.newest("console").get("pressers")))
        [presser] = host.newest("console")["pressers"]
        host.say(type="mute_address", presser=presser["id"], muted=True)
        host.release(host.stopped or 0)
        assert await host.until(lambda: host.stopped is None)
        assert str(MUTED) in await refusal(known.press_stop())


async def test_nobody_waits_by_http_alone(server: Server, host: Operator) -> None:
    """Where there are no rooms to watch in; no request leaves a place, or anybody in the room."""
    _, before = await server.get("/api/status", host.cookies)
    async with aiohttp.ClientSession(headers=_from(TROLLS)) as http:
        for number in range(12):
            body = {"client": f"waiting-{number:02}", "wants": "join"}
            async with http.post(f"{server.url}/api/queue", json=body) as response:
                assert response.status == 403
            http.cookie_jar.clear()
    _, after = await server.get("/api/status", host.cookies)
    assert len(after["viewers"]) <= len(before["viewers"])
    assert after["turn"]["number"] == before["turn"]["number"]


async def test_a_copied_host_cookie_is_taken_back(serve: Serve, tmp_path: Path) -> None:
    """By the host's other page it is a host's until then; afterwards it opens nothing."""
    async with serve(tmp_path, toml.card_with()) as server:
        mine, copied = await server.host_cookies(), await server.host_cookies()
        async with (
            Operator(server.url, cookies=mine) as host,
            Operator(server.url, cookies=copied) as thief,
        ):
            assert (await server.get("/api/status", copied))[0] == 200
            host.say(type="sign_out_others")
            assert await thief.until(lambda: bool(thief.newest("ended")))
            assert (await server.get("/api/status", copied))[0] == 403
            assert (await server.get("/api/status", mine))[0] == 200


async def test_the_hosts_stop_is_released_by_the_host(host: Operator, come: Come) -> None:
    """The operator cannot, on the channel or by HTTP; that they press again changes nothing."""
    operator = await come()
    await operator.join()
    stop = await host.press_stop()
    assert await operator.until(lambda: operator.stopped == stop)
    assert await operator.press_stop() == stop
    operator.release(stop)
    says = Refusal.THE_HOSTS_STOP.value
    assert await operator.until(lambda: operator.newest("notice").get("text") == says.wire())
    assert str(says) in await refusal(operator.post("/api/release", {"stop": stop}))
    assert host.stopped == stop
    host.release(stop)
    assert await operator.until(lambda: operator.stopped is None)


async def test_two_tabs_are_one_person(come: Come) -> None:
    """They have one place in the queue together, and there are four of them at most."""
    driving, first = await come(), await come()
    await driving.join()
    tabs = [await come(cookies=first.cookies) for _ in range(3)]
    first.say(type="join")
    assert await first.until(lambda: _place(first, first.viewer) == 1)
    tabs[0].say(type="join")
    assert await tabs[0].until(
        lambda: tabs[0].newest("notice").get("text") == {"code": "queue.other_tab"}
    )
    assert _place(tabs[0], tabs[0].viewer) is None
    assert str(TOO_MANY_TABS) in await refusal(come(cookies=first.cookies))


async def test_a_troll_stays_out(
    server: Server, host: Operator, come: Come, open_viewer: OpenViewer
) -> None:
    """Removed and banned, their page ends; a new browser from their address does not come in."""
    proxied = {"extra_http_headers": _from(TROLLS)}
    troll = await open_viewer(server, **proxied)
    await troll.call_oneself("Troll")
    assert await host.until(lambda: _number(host, "Troll") is not None)
    host.say(type="remove", viewer=_number(host, "Troll"), ban=True)
    await troll.page.get_by_text(str(BANNED)).first.wait_for(timeout=5000)
    assert await host.until(lambda: _number(host, "Troll") is None)
    assert str(BANNED) in await refusal(come(TROLLS))
    again = await come("192.0.2.67")

    host.say(type="lock", locked=True)
    try:
        assert await again.until(lambda: again.newest("ended").get("text") == LOCKED.wire())
    finally:
        host.say(type="lock", locked=False)
    assert await host.until(lambda: host.newest("room")["house"]["locked"] is False)


async def test_a_lock_keeps_the_invited(server: Server, host: Operator, come: Come) -> None:
    """Strangers are sent away and stay out; whoever was invited stays, and comes in again."""
    token = await invited(host, uses=1)
    stranger, friend = await come(), await come()
    assert await enter(server, token, friend.cookies) == (200, "queue")
    host.say(type="lock", locked=True)
    try:
        assert await stranger.until(lambda: stranger.newest("ended").get("text") == LOCKED.wire())
        assert str(LOCKED) in await refusal(come())
        assert await friend.pongs()
        await friend.join()
        assert (await come(cookies=friend.cookies)).is_open
    finally:
        host.say(type="lock", locked=False)
    assert await host.until(lambda: host.newest("room")["house"]["locked"] is False)


async def test_bad_invitations_say_why(server: Server, host: Operator) -> None:
    """Over, of the future, forged, cut off, used up or no token at all: each has its sentence."""
    secret = (server.state_folder / FILE).read_bytes()
    now_s = SystemClock().wall_ms() / 1000
    over = Keyring(secret, lambda: now_s - 7200).invite("queue", uses=5, valid_s=3600)
    early = Keyring(secret, lambda: now_s + 7200).invite("queue", uses=5, valid_s=3600)
    forged = Keyring(bytes(SECRET_BYTES), lambda: now_s).invite("queue", uses=5, valid_s=3600)
    good = await invited(host, uses=1)
    not_ours = (403, "not this robot's, or was cut off")
    expected = {
        over: (403, "This invitation is over"),
        early: (403, "the robot's clock is wrong"),
        forged: not_ours,
        good[:-4]: not_ours,
        "é\0": not_ours,
        "": (400, "token"),
    }
    for token, (status, sentence) in expected.items():
        code, said = await enter(server, token, None)
        assert (code, sentence in said) == (status, True), said
    jar = aiohttp.CookieJar(unsafe=True)
    for _ in range(2):  # the same person may come again
        assert await enter(server, good, jar) == (200, "queue")
    code, said = await enter(server, good, None)
    assert (code, said.startswith("This invitation is used up")) == (403, True)


async def test_blanked_there_is_nothing_to_see(
    server: Server, host: Operator, come: Come, open_viewer: OpenViewer
) -> None:
    """While the host wants privacy the picture is black, the sound silent, and the robot stands."""
    viewer = await open_viewer(server)
    await viewer.listen()
    operator = await come(sees=True)
    await operator.join()

    async def turns() -> bool:
        operator.let_go()
        await asyncio.sleep(0.1)
        operator.steer(0.0, 1.0)
        return await moves(server)

    async def loudest() -> float:
        viewer.forget()
        await asyncio.sleep(0.4)
        return max((one.rms for one in viewer.heard()), default=0.0)

    async def is_dark() -> bool:
        return bool(await viewer.page.evaluate(LUMA) <= BLACK)

    async def is_silent() -> bool:
        return await loudest() <= SILENT

    await eventually(turns, "the robot turns")
    assert await loudest() > SILENT
    assert not await is_dark()
    host.say(type="blank", blanked=True)
    try:
        assert await stands_still(server)
        await eventually(is_dark, "the picture is black", within_s=5)
        await eventually(is_silent, "the sound is silent", within_s=5)
        assert not await turns()
    finally:
        host.say(type="blank", blanked=False)
    await eventually(turns, "the robot turns again")
    assert await loudest() > SILENT


async def test_no_secret_is_in_the_log(server: Server, come: Come) -> None:
    """What lets somebody in is nowhere in the log, at its most talkative, not even when refused."""
    link = server.host_url().partition("#host=")[2]
    jar = await server.host_cookies()
    host = await come(cookies=jar)
    token = await invited(host, uses=1)
    guest = await come()
    await enter(server, token, guest.cookies)
    await enter(server, token + "x", None)
    async with aiohttp.ClientSession(headers=_from(HERS)) as http:
        for secret in (link, link):
            await (await http.post(f"{server.url}/api/host", json={"secret": secret})).read()
        await (await http.get(f"{server.url}/?host={'x' * 300}")).read()
    cookies = [one for client in (host, guest) for one in client.cookies]
    assert sorted(one.key for one in cookies) == ["wax-host", "wax-id", "wax-id"]
    assert "a host link was made" in server.log
    for secret in (link, token, *(one.value for one in cookies)):
        assert len(secret) >= 16
        assert secret not in server.log


# --- who asks --------------------------------------------------------------------------------


def _from(address: str) -> dict[str, str]:
    """Return what a proxy says about whom it asks for."""
    return {"X-Forwarded-For": address}


async def refusal(request: Awaitable[Any]) -> str:
    """Return what the server says when it refuses a request."""
    with pytest.raises(SignallingError) as refused:
        await request
    return str(refused.value)


async def invited(host: Operator, *, uses: int) -> str:
    """Return the token of a new invitation to the queue."""
    before = host.newest("invitation").get("token")
    host.say(type="invite", purpose="queue", uses=uses, valid_s=3600)
    assert await host.until(lambda: host.newest("invitation").get("token") != before)
    return str(host.newest("invitation")["token"])


async def enter(server: Server, token: str, cookies: aiohttp.CookieJar | None) -> tuple[int, str]:
    """Return the HTTP status and the purpose, or the sentence, for a token."""
    async with (
        aiohttp.ClientSession(headers=_from("192.0.2.8"), cookie_jar=cookies) as http,
        http.post(f"{server.url}/api/enter", json={"token": token}) as response,
    ):
        said = await response.json()
    return response.status, said.get("purpose") or said["error"]


def _number(client: Client, name: str) -> int | None:
    """Return the number of the viewer with this name."""
    viewers = client.newest("room").get("viewers", [])
    return next((one["id"] for one in viewers if one["name"] == name), None)


def _place(client: Client, viewer: int | None) -> int | None:
    """Return a viewer's place in the queue."""
    viewers = client.newest("room").get("viewers", [])
    return next((one["place"] for one in viewers if one["id"] == viewer), None)


@asynccontextmanager
async def forwarded(port: int) -> AsyncIterator[str]:
    """Forward another port of this machine, as ``ssh -R`` does; yields the URL there."""

    async def pump(source: StreamReader, sink: StreamWriter) -> None:
        with suppress(OSError):
            while piece := await source.read(65_536):
                sink.write(piece)
                await sink.drain()
        sink.close()

    async def hand_on(reader: StreamReader, writer: StreamWriter) -> None:
        from_there, to_there = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(pump(reader, to_there), pump(from_there, writer))

    async with await asyncio.start_server(hand_on, "127.0.0.1", 0) as listening:
        yield f"http://127.0.0.1:{listening.sockets[0].getsockname()[1]}"
