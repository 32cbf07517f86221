"""A night as the host sees it afterwards, and what nobody must find in it."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING, Any

import aiohttp
import pytest

from e2e.harness import toml
from e2e.harness.server import COMMAND, Server, free_port
from wax.access import host_link
from wax.client import Client
from wax.client.host import become_host
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve


async def recorded(server: Server) -> dict[str, list[dict[str, Any]]]:
    """Return what `wax records` prints, in a process of its own."""
    process = await asyncio.create_subprocess_exec(
        *(str(COMMAND), "records", "--json"),
        stdout=asyncio.subprocess.PIPE,
        env=os.environ | server.environment,
    )
    out, _ = await process.communicate()
    assert process.returncode == 0
    found: dict[str, list[dict[str, Any]]] = json.loads(out)
    return found


@pytest.mark.full
@pytest.mark.timeout(60)
async def test_a_night(serve: Serve, tmp_path: Path) -> None:
    """Visits, turns and stops are there while the server runs; Ctrl-C ends what is open."""
    async with serve(tmp_path, toml.CARD) as server:
        async with Operator(server.url, name="Ada") as ada:
            await ada.join()
            await ada.gets_turn()
            ada.say(type="stop")
            assert await ada.until(lambda: ada.stopped is not None)
            ada.release(ada.stopped or 0)
            assert await ada.until(lambda: ada.stopped is None)
            await ada.leave()
            await ada.join()
            await asyncio.sleep(2.5)
            tables = await recorded(server)
            assert [(one["name"], one["ended"]) for one in tables["sessions"]] == [("Ada", None)]
            assert [one["why"] for one in tables["turns"]] == ["left", None]
        await server.stop(signal.SIGINT)  # her turn is kept for the grace time
    tables = await recorded(server)
    (session,) = tables["sessions"]
    assert (session["address"], session["role"]) == ("127.0.0.0/24", "guest")
    assert session["began"] < session["ended"]
    assert session["round_trip_ms"] is not None
    assert [one["why"] for one in tables["turns"]] == ["left", "server stopped"]
    (pressed,) = tables["stops"]
    assert (pressed["name"], pressed["reason"], pressed["released_by"]) == ("Ada", "pressed", "Ada")


@pytest.mark.full
@pytest.mark.timeout(60)
async def test_a_crash_costs_a_second(serve: Serve, tmp_path: Path) -> None:
    """A killed server's file opens; the next server says what was cut off."""
    async with serve(tmp_path, toml.CARD) as server:
        async with Operator(server.url, name="Ada") as ada:
            await ada.join()
            await ada.gets_turn()
            await asyncio.sleep(2.0)
        await server.kill()
        await server.exit_code(5)
        assert [one["why"] for one in (await recorded(server))["turns"]] == [None]
        await server.start()
        await asyncio.sleep(1.0)
        tables = await recorded(server)
        assert [one["why"] for one in tables["turns"]] == ["server killed"]
        assert tables["sessions"][0]["ended"] is not None


@pytest.mark.timeout(60)
async def test_no_secret_and_nothing_raw_is_logged(tmp_path: Path) -> None:
    """Neither log nor records hold what would let one in as somebody else, at any level."""
    server = Server(tmp_path, toml.CARD + '[log]\nlevel = "debug"\n')
    await server.start()
    state = tmp_path / "state" / "wax"
    evil = "\x1b]0;evil\x07\u202egnp.exe\n[warning] forged"
    try:
        async with Client(server.url, name=evil) as eve:
            eve.say(type="name", name=evil)
            eve.say(type="nonsense", **{evil: evil})
            eve.state.send(evil)
            jar = aiohttp.CookieJar(unsafe=True)  # its host is an address
            async with aiohttp.ClientSession(cookie_jar=jar) as session:
                await become_host(session, server.url, state)
                for body in ({"client": eve.client_id}, {"client": evil}, {evil: 1}):
                    for path in ("/api/stop", "/api/offer", "/api/release"):
                        async with session.post(server.url + path, json=body) as response:
                            await response.read()
            await asyncio.sleep(2.5)
            link, *_ = await asyncio.to_thread(host_link.ask, state)
        secrets = [eve.client_id, link.partition("#host=")[2], *(cookie.value for cookie in jar)]
        assert len(secrets) >= 3
        assert all(map(len, secrets))
        await server.stop()
    finally:
        await server.kill()
    files = [server.log_path, *(one for one in state.iterdir() if one.is_file())]
    assert len(files) >= 2
    for file in files:
        content = file.read_bytes()
        assert not [secret for secret in secrets if secret.encode() in content], file
    assert not set("\x1b\x07\u202e") & set(server.log)
    assert not [line for line in server.log.splitlines() if line.startswith("[warning] forged")]
    with closing(sqlite3.connect(state / "records.db")) as records:
        names = [name for (name,) in records.execute("SELECT name FROM sessions")]
    assert names
    assert not set("\x1b\x07\u202e\n") & set("".join(names))


@pytest.mark.full
@pytest.mark.timeout(60)
async def test_a_locked_file_stops_nobody(serve: Serve, tmp_path: Path) -> None:
    """Somebody holds the file while people drive: they notice nothing, and nothing is lost."""
    async with serve(tmp_path, toml.CARD) as server:
        path = tmp_path / "state" / "wax" / "records.db"
        with closing(sqlite3.connect(path, isolation_level=None, timeout=5)) as other:
            other.execute("BEGIN EXCLUSIVE")
            async with Operator(server.url, name="Ada") as ada:
                await ada.join()
                await ada.gets_turn()
                await ada.leave()
                await asyncio.sleep(3.0)
            other.execute("ROLLBACK")
        await server.stop()
    assert [one["why"] for one in (await recorded(server))["turns"]] == ["left"]
    assert server.log.count("records cannot be written") <= 1


@pytest.mark.timeout(60)
async def test_seen_from_outside(tmp_path: Path) -> None:
    """Metrics on their own port only, readiness on the page's."""
    port = free_port()
    server = Server(tmp_path, toml.CARD + f"[metrics]\nport = {port}\n")
    await server.start()
    try:
        async with Operator(server.url) as ada, aiohttp.ClientSession() as session:
            await ada.join()
            await ada.gets_turn()
            await asyncio.sleep(0.5)
            async with session.get(f"http://127.0.0.1:{port}/metrics") as response:
                text = await response.text()
            assert 'wax_viewers{role="operator"} 1.0' in text
            assert "wax_loop_lateness_seconds_bucket" in text
            async with session.get(f"{server.url}/metrics") as response:
                assert response.status == 404
            async with session.get(f"{server.url}/readyz") as response:
                assert (response.status, (await response.json())["ready"]) == (200, True)
        await server.stop()
    finally:
        await server.kill()
