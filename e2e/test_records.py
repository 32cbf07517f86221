"""What a server records, and what nobody must find there."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import aiohttp
from tests.free_port import free_port

from e2e.harness import toml
from wax.access import host_link
from wax.client import Client
from wax.client.host import become_host
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve


async def test_no_secret_and_nothing_raw_is_logged(serve: Serve, tmp_path: Path) -> None:
    """Log, records and metrics contain nothing that admits somebody else, at any level."""
    state = tmp_path / "state" / "wax"
    evil = "\x1b]0;evil\x07\u202egnp.exe\n[warning] forged"
    port = free_port()
    tables = {"log": 'level = "debug"', "metrics": f"port = {port}"}
    async with serve(tmp_path, toml.card_with(**tables)) as server:
        async with Client(server.url, name=evil) as eve:
            eve.send(type="name", name=evil)
            eve.send(type="nonsense", **{evil: evil})
            eve.state.send(evil)
            jar = aiohttp.CookieJar(unsafe=True)  # its host is an address
            async with aiohttp.ClientSession(cookie_jar=jar) as session:
                await become_host(session, server.url, state)
                for body in ({"client": eve.client_id}, {"client": evil}, {evil: 1}):
                    for path in ("/api/stop", "/api/offer", "/api/release"):
                        async with session.post(server.url + path, json=body) as response:
                            await response.read()
            async with Operator(server.url, cookies=jar) as host:
                host.send(type="invite", purpose="queue", uses=1, valid_s=3600)
                assert await host.until(lambda: bool(host.newest("invitation")), 20)
                token = str(host.newest("invitation")["token"])
            link, *_ = await asyncio.to_thread(host_link.request_links, state)
            secret = link.partition("#host=")[2]
            async with aiohttp.ClientSession() as session:
                for path, body in (
                    *(("enter", {"token": one}) for one in (token, f"{token}x")),
                    *[("host", {"secret": secret})] * 2,  # it works only once
                ):
                    async with session.post(f"{server.url}/api/{path}", json=body) as sent:
                        await sent.read()
                await (await session.get(f"{server.url}/?host={secret}")).read()
                seen = await (await session.get(f"http://127.0.0.1:{port}/metrics")).text()
            # Metrics are on their own port only, and readiness on the page's.
            assert 'wax_viewers{role="observer"} ' in seen
            assert "wax_loop_lateness_seconds_bucket" in seen
            assert (await server.get("/metrics"))[0] == 404
            code, told = await server.get("/readyz")
            assert (code, told["ready"]) == (200, True)
            await asyncio.sleep(2.5)
        secrets = [eve.client_id, secret, token, *(one.value for one in (*jar, *eve.cookies))]
        assert {one.key for one in jar} == {"wax-host", "wax-id"}
        assert all(len(one) >= 16 for one in secrets)
        assert "a host link was made" in server.log
    files = [server.log_path, *(one for one in state.iterdir() if one.is_file())]
    assert len(files) >= 2
    for content in (seen.encode(), *(file.read_bytes() for file in files)):
        assert not [secret for secret in secrets if secret.encode() in content]
    assert not set("\x1b\x07\u202e") & set(server.log)
    assert not [line for line in server.log.splitlines() if line.startswith("[warning] forged")]
    with closing(sqlite3.connect(state / "records.db")) as records:
        names = [name for (name,) in records.execute("SELECT name FROM sessions")]
    assert names
    assert not set("\x1b\x07\u202e\n") & set("".join(names))
