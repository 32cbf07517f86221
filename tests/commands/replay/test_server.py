"""The HTTP server of `wax replay`: for this machine's browser, and nobody else."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final

import pytest
from aiohttp.test_utils import TestClient, TestServer
from tests.commands.replay.recorded import BEGIN_S, CAMERAS, record
from tests.turned_clock import TurnedClock

from wax.commands.replay.library import Library
from wax.commands.replay.server import ReplayServer
from wax.config.server import ServerSettings
from wax.errors import StartError
from wax.protocol.tape_events import FORMAT
from wax.tape import event_file
from wax.tape.shelf import Shelf
from wax.web.guards import Guards

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from aiohttp.web import Application, Request

    Client = TestClient[Request, Application]


SECRET: Final = "Zk3"
AT: Final = f"/{SECRET}"


@pytest.fixture
def name(tmp_path: Path) -> str:
    """Record one part of a tape; return its name."""
    return record(Shelf(tmp_path), BEGIN_S)


@pytest.fixture
async def client(tmp_path: Path, name: str) -> AsyncIterator[Client]:
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("<!doctype html><title>tape</title>")
    library = Library(tmp_path)
    guards = Guards(ServerSettings(host="localhost"), TurnedClock())
    async with TestClient(
        TestServer(ReplayServer(library, guards, SECRET, page).application())
    ) as found:
        yield found
    library.close()


async def test_the_page_is_served_with_its_policy(client: Client) -> None:
    """The page has the robot page's policy: nothing inline, nothing from elsewhere."""
    response = await client.get(AT + "/")
    assert response.status == 200
    assert "tape" in await response.text()
    assert "default-src 'self'" in response.headers["Content-Security-Policy"]


async def test_the_tape_is_listed_and_read(client: Client, name: str) -> None:
    """The tape is listed and read as JSON of the page's models."""
    listing = await (await client.get(AT + "/api/tape")).json()
    assert [one["name"] for one in listing["parts"]] == [name]
    response = await client.get(AT + f"/api/tape/{name}")
    content = await response.json()
    assert content["events"][0]["event"]["type"] == "stopped"
    assert response.headers["Cache-Control"] == "no-store"


async def test_a_browser_can_seek(client: Client, name: str) -> None:
    """A range request is answered with that range."""
    whole = await client.get(AT + f"/media/{name}")
    assert whole.headers["Content-Type"] == "video/webm"
    data = await whole.read()
    part = await client.get(AT + f"/media/{name}", headers={"Range": "bytes=100-199"})
    assert part.status == 206
    assert await part.read() == data[100:200]


async def test_a_camera_has_a_file_of_its_own(client: Client, tmp_path: Path) -> None:
    """A camera's file has its number, and its codec's content type."""
    name = record(Shelf(tmp_path), BEGIN_S + 20, CAMERAS)
    content = await (await client.get(AT + f"/api/tape/{name}")).json()
    assert [one["number"] for one in content["cameras"]] == [1, 2]
    for number, kind in ((1, "video/webm"), (2, "video/mp4")):
        url = AT + f"/media/{name}/{number}"
        found = await client.get(url, headers={"Range": "bytes=0-99"})
        assert (found.status, found.headers["Content-Type"]) == (206, kind)
    for bad in ("3", "0", "999"):
        response = await client.get(AT + f"/media/{name}/{bad}")
        assert response.status == 404
        assert "error" in await response.json()


@pytest.mark.parametrize("path", ["/api/tape/gone", "/media/gone", "/media/..%2Fpage"])
async def test_what_is_not_there_is_said(client: Client, path: str) -> None:
    """A missing part is a sentence in JSON."""
    response = await client.get(AT + path)
    assert response.status == 404
    assert "error" in await response.json()


async def test_a_newer_part_is_said(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part of a newer version is a sentence; the folder's others still play."""
    monkeypatch.setattr(event_file, "FORMAT", FORMAT + 1)
    newer = record(Shelf(tmp_path), BEGIN_S + 10)
    response = await client.get(AT + f"/api/tape/{newer}")
    assert response.status == 404
    assert "update WAX" in (await response.json())["error"]
    assert len((await (await client.get(AT + "/api/tape")).json())["parts"]) == 2


async def test_a_part_that_is_cut_is_played_up_to_there(
    client: Client, tmp_path: Path, name: str
) -> None:
    """A truncated part plays and seeks up to its end, with a sentence about the rest."""
    for ending, share in ((".mcap", 0.5), (".webm", 0.7)):
        path = tmp_path / (name + ending)
        os.truncate(path, int(path.stat().st_size * share))
    content = await (await client.get(AT + f"/api/tape/{name}")).json()
    assert "cut off" in content["problem"]
    part = await client.get(AT + f"/media/{name}", headers={"Range": "bytes=0-99"})
    assert part.status == 206


@pytest.mark.parametrize("ending", [".mcap", ".webm"])
async def test_fifty_gigabytes_are_refused_at_once(
    client: Client, tmp_path: Path, name: str, ending: str
) -> None:
    """A file too large for a part is refused with a sentence."""
    os.truncate(tmp_path / (name + ending), 50_000_000_000)
    response = await client.get(AT + f"/api/tape/{name}")
    assert response.status == 404
    error = (await response.json())["error"]
    assert "50.0 GB" in error or "50 GB" in error
    assert "give the tape's folder" in error


@pytest.mark.parametrize("path", ["/", "/api/tape", "/index.html", "/Zk4/api/tape", "/Zk/"])
async def test_who_does_not_know_the_address_gets_nothing(client: Client, path: str) -> None:
    """Without the secret path there is no answer: other users of this machine reach its ports."""
    response = await client.get(path)
    assert response.status == 404
    assert await response.json() == {"error": "Not Found"}


async def test_another_sites_page_gets_nothing(client: Client) -> None:
    """A request by another host name (DNS rebinding) is refused."""
    response = await client.get(AT + "/api/tape", headers={"Host": "evil.example"})
    assert response.status == 421


async def test_a_page_that_is_not_built_is_said(tmp_path: Path, name: str) -> None:
    """A page that is not built is a sentence at the start."""
    library = Library(tmp_path / f"{name}.mcap")
    guards = Guards(ServerSettings(), TurnedClock())
    with pytest.raises(StartError, match="not built"):
        ReplayServer(library, guards, SECRET, tmp_path / "nowhere").application()
    library.close()
