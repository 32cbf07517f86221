"""The composition root: starts everything, stops the robot first, dies with its parts."""

from __future__ import annotations

import asyncio
import json
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiohttp
import cv2
import numpy as np
import pytest
from structlog.testing import capture_logs
from tests.hooks.receiver import receiving, secret_file
from tests.until import async_until

from wax.app import App
from wax.capture.source import Picture
from wax.capture.source_thread import SourceThread
from wax.client.host import become_host
from wax.clock import SystemClock
from wax.config.settings import Settings
from wax.control.turns import Turns
from wax.door.tunnel import Tunnel
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import RobotState
from wax.errors import StartError
from wax.machine import memory
from wax.protocol.robot_report import ROBOT_NUMBERS
from wax.robot.simulated.robot import SimulatedRobot
from wax.sentence import Sentence
from wax.session.kept_state import KeptFile
from wax.session.status import Status
from wax.streams.live import LiveService
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of
from wax.tape.shelf import Shelf
from wax.web import routes

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path


pytestmark = pytest.mark.system


@pytest.fixture(autouse=True)
def _page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "index.html").write_text("<!doctype html>")
    monkeypatch.setattr(routes, "PAGE", tmp_path)


@pytest.fixture(autouse=True)
def state_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Use a state folder of our own, with a path short enough for a socket."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    return tmp_path / "wax"


NO_DEVICES: dict[str, Any] = {"video": {"source": "none"}, "audio": {"source": "none"}}
"""The machine's own devices are not under test, and searching for them may take seconds."""


def _app(*tables: dict[str, Any], **video: object) -> App:
    tree: dict[str, Any] = {
        "server": {"host": "127.0.0.1", "port": 0},
        "network": {"udp_port": 0},
        "video": {"source": "testcard", "width": 640, "height": 480, **video},
        "audio": {"source": "testcard"},
    }
    for one in tables:
        tree |= one
    return App(settings=Settings.model_validate(tree), clock=SystemClock())


@asynccontextmanager
async def started(app: App) -> AsyncIterator[int]:
    """Run the app on a port, and check that it stops within 5 s after the block."""
    ports: asyncio.Queue[int] = asyncio.Queue()
    running = asyncio.create_task(app.run(ports.put_nowait))
    try:
        yield await asyncio.wait_for(ports.get(), 10)
    finally:
        app.stop()
        await asyncio.wait_for(running, 5)


@pytest.mark.parametrize(
    ("more", "data"),
    [
        ({}, ""),
        ({"sync": {"observer": {"player": "browser"}}}, ""),
        (
            {"sync": {role: {"player": "browser"} for role in ("operator", "observer")}},
            "data-player",
        ),
        ({"sync": {"policy": "thesis"}}, "data-acknowledge"),
        ({"voice": {"speaker": "robot"}}, "data-voice"),
    ],
)
async def test_the_page_is_told_what_to_prepare(
    tmp_path: Path, more: dict[str, Any], data: str
) -> None:
    """The page learns before it connects whether it must acknowledge packets or may speak."""
    (tmp_path / "index.html").write_text('<!doctype html><html lang="en"></html>')
    async with started(_app(NO_DEVICES, more)) as port:
        text = await _text(port, "/")
    told = set(re.findall(r"data-[a-z]+", text)) - {"data-name"}
    assert told == ({data} if data else set())


async def test_a_frame_on_another_site_has_the_shape_of_the_turned_picture() -> None:
    """A camera of 480×270 that lies on its side is framed without bars."""
    frames = {"page": {"embed_on": ["https://museum.example"]}, "audio": {"source": "none"}}
    async with started(_app(frames, width=480, height=270, rotate=90)) as port:
        told = json.loads(await _text(port, f"/oembed?url=http://127.0.0.1:{port}/"))
    assert (told["width"], told["height"]) == (640, 640 * 480 // 270)


async def _text(port: int, path: str) -> str:
    url = f"http://127.0.0.1:{port}{path}"
    async with aiohttp.ClientSession() as session, session.get(url) as response:
        return await response.text()


async def _status(
    port: int, state_folder: Path, tells: Callable[[dict[str, Any]], bool]
) -> dict[str, Any]:
    """Return the host's status once it shows that."""
    url = f"http://127.0.0.1:{port}"
    jar = aiohttp.CookieJar(unsafe=True)
    async with (
        aiohttp.ClientSession(cookie_jar=jar, raise_for_status=True) as session,
        asyncio.timeout(20),
    ):
        await become_host(session, url, state_folder)
        while True:
            async with session.get(f"{url}/api/status") as response:
                status: dict[str, Any] = await response.json()
            if tells(status):
                return status
            await asyncio.sleep(0.1)


async def test_it_serves_until_it_is_stopped(
    state_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The status has every part while the app runs, and stopping leaves nothing behind."""
    looked = asyncio.Event()
    monkeypatch.setattr(memory, "collect_young", looked.set)

    def tells_of_both(status: dict[str, Any]) -> bool:
        video, audio = status["streams"]["video"], status["streams"]["audio"]
        return bool(video["captured_fps"] and audio["captured_hz"])

    async with started(_app()) as port:
        status = await _status(port, state_folder, tells_of_both)
        await asyncio.wait_for(looked.wait(), 5)
    assert (status["viewers"], status["turn"]["operator"]) == ([], None)
    assert status["robot"]["kind"] == "simulated"
    video = status["streams"]["video"]
    assert (video["problem"], video["dropped"], video["wanted"]) == (None, 0, [])
    assert video["captured_fps"] < 10  # nobody needs it
    assert cv2.getNumThreads() == 1
    assert video["encoder"] == {"chosen": "libvpx", "ms": {}, "refused": {}, "failed": {}}
    audio = status["streams"]["audio"]
    assert (audio["failures"], audio["filled_ms"], audio["cut_ms"]) == (0, 0, 0)
    assert audio["captured_hz"] < 10


async def test_its_opening_hours_are_a_calendar() -> None:
    """The configured opening hours are served as a calendar."""
    tables = {
        "access": {"hours": ["mon-fri 09:00-18:00"], "time_zone": "Europe/Berlin"},
        "page": {"name": "Rover"},
    }
    async with started(_app(NO_DEVICES, tables)) as port:
        text = await _text(port, "/open.ics")
    assert "\r\nSUMMARY:Rover\r\n" in text
    assert "\r\nBEGIN:VEVENT\r\n" in text


async def test_a_driver_that_raises_takes_nothing_down(
    state_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A driver whose `state` raises is a problem in the status, and stops nothing else."""

    def fail(self: SimulatedRobot) -> RobotState:
        raise OSError("no bus")

    monkeypatch.setattr(SimulatedRobot, "state", fail)
    async with started(_app()) as port:
        status = await _status(
            port, state_folder, lambda status: status["robot"]["problem"] == str(NO_ANSWER)
        )
    assert status["robot"] == {
        "kind": "simulated",
        "connected": False,
        "problem": str(NO_ANSWER),
        "moving": None,
        "pose": None,
        "bumpers": 0,
        "gauges": {},
        "controls": {},
        **dict.fromkeys(ROBOT_NUMBERS),
        "aboard": None,
    }


async def test_a_stop_outlives_the_server(state_folder: Path) -> None:
    """A Stop survives a restart until somebody who may releases it."""
    jar = aiohttp.CookieJar(unsafe=True)
    async with started(_app(NO_DEVICES)) as port, aiohttp.ClientSession(cookie_jar=jar) as session:
        await become_host(session, url := f"http://127.0.0.1:{port}", state_folder)
        async with session.post(f"{url}/api/stop", json={}) as response:
            assert response.ok
    async with started(_app(NO_DEVICES)) as port:
        status = await _status(port, state_folder, lambda found: bool(found["stop"]))
    assert status["stop"] == {"number": 1, "by": "the host"}


async def test_a_disk_too_slow_for_its_end_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    close = KeptFile.close
    monkeypatch.setattr(KeptFile, "close", lambda kept: close(kept) is None)
    with capture_logs() as logs:
        async with started(_app(NO_DEVICES)):
            pass
    assert [line["event"] for line in logs if line.get("error") == "a slow disk"]


async def test_no_driver_hides_the_status(monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver's extra status is shown, and overrides none of the fields."""
    extra = {"connected": 0.0, "kind": 7.0, "bumpers": 9.0, "wheel_slip": 0.5}
    state = RobotState(connected=True, bumpers=2, extra=extra)
    monkeypatch.setattr(SimulatedRobot, "state", lambda _: state)
    app = _app()
    app._parts.control.step(SystemClock().now_s())
    robot = app._status()["robot"]
    app._parts.control.stop()
    assert isinstance(robot, dict)
    shown = {name: robot[name] for name in ("connected", "kind", "bumpers", "wheel_slip")}
    assert shown == {"connected": True, "kind": "simulated", "bumpers": 2, "wheel_slip": 0.5}


async def test_a_part_that_dies_takes_the_server_down(monkeypatch: pytest.MonkeyPatch) -> None:
    """A task that dies stops the robot, then the server, with a sentence that names the task."""

    async def die(self: Status) -> None:
        raise RuntimeError("bug")

    monkeypatch.setattr(Status, "run", die)
    app = _app()
    told: list[str] = []
    close = app._parts.driver.close

    def noted_close() -> None:
        told.append("close")
        close()

    monkeypatch.setattr(app._parts.driver, "stop", lambda _turn: told.append("stop"))
    monkeypatch.setattr(app._parts.driver, "close", noted_close)
    with pytest.raises(StartError, match="'status' failed"):
        await asyncio.wait_for(app.run(lambda _port: None), 10)
    assert told[0] == "stop"
    assert told[-1] == "close"


async def test_the_streams_are_told_how_late_the_loop_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """They get the larger mean delay of the control loop's ticks and of the peers' datagrams."""
    told: list[float] = []
    monkeypatch.setattr("wax.app._RELIEVE_S", 0.05)
    monkeypatch.setattr(LiveService, "relieve", lambda _, late_s: told.append(late_s))
    async with started(app := _app()):
        await async_until(lambda: any(told))
        assert max(told) < 1
        app._turnstile._entries, app._turnstile._waited_s = 10, 50.0
        await async_until(lambda: max(told) == 5)


async def test_a_taken_port_is_a_sentence() -> None:
    """A second server on the same port does not start, and says what to do."""
    async with started(_app()) as port:
        second = _app(NO_DEVICES, {"server": {"host": "127.0.0.1", "port": port}})
        with pytest.raises(StartError, match=f"TCP port {port} of .* in use.*`ss -.*--port"):
            await second.run(lambda _port: None)


@pytest.mark.parametrize("is_on", [False, True])
async def test_the_overlay_is_switched_by_its_key(is_on: bool) -> None:
    """With `[video] timestamp_overlay` each picture carries its time."""
    app = _app(timestamp_overlay=is_on)
    picture = Picture(np.full((720, 640), 90, np.uint8), SystemClock().now_s())
    app._parts.pipelines.captures["video"]._sink(picture)  # type: ignore[arg-type]  # it is the camera's
    found = app._parts.pipelines.video.slot.newer_than(0, 0.0)
    assert found is not None
    assert (found[1].i420 != picture.i420).any() == is_on


async def test_a_taken_udp_port_is_a_sentence() -> None:
    """A second server beside the first, on another port of its own, needs another UDP port too."""
    first = _app()
    async with started(first):
        taken = first._parts.network.udp_port
        second = _app(NO_DEVICES, {"network": {"udp_port": taken}})
        with pytest.raises(StartError, match=f"UDP port {taken}.*in use.*`ss -.*--udp-port"):
            await second.run(lambda _port: None)


async def test_what_happens_is_recorded_where_it_is_configured(state_folder: Path) -> None:
    """The tape has picture, sound and the robot's state, and ends with the server."""
    app = _app({"recording": {"enabled": True, "min_free_gb": 0.0}})

    def captures() -> bool:
        streams: Any = app._status()["streams"]
        return bool(streams["video"]["captured_fps"] and streams["audio"]["captured_hz"])

    async with started(app):
        async with asyncio.timeout(20):
            while not captures():  # noqa: ASYNC110  # as the page asks
                await asyncio.sleep(0.05)
        await asyncio.sleep(2.0)  # of which a second and more is to be on the tape
        told = app._status()["tape"]
    assert isinstance(told, dict)
    assert (told["problem"], told["left_out"]) == (None, 0)
    (part,) = Shelf(state_folder / "tape").parts()
    assert part.media is not None
    assert part.events is not None
    facts = facts_of(part.media)
    assert facts.has_picture
    assert facts.has_sound
    assert facts.length_ms > 1000
    read = read_events(part.events)
    assert read.problem is None
    assert {"steered", "reported"} <= {one.event.type for one in read.events}


async def test_a_hook_is_told_from_the_beginning_to_the_end(tmp_path: Path) -> None:
    """A hook gets the events from the first to the last, and a dead receiver delays nothing."""
    async with receiving() as receiver:
        urls = [receiver.url, "http://127.0.0.1:9/"]
        hooks = [{"url": url, "secret_file": secret_file(tmp_path)} for url in urls]
        app = _app(NO_DEVICES, {"hook": hooks})
        async with started(app):
            for _ in range(2):
                await asyncio.wait_for(receiver.arrived.get(), 10)
            async with asyncio.timeout(10):  # until its answer is read, it would be told again
                while app._parts.hooks.status()[0]["waiting"]:  # noqa: ASYNC110  # as the page asks
                    await asyncio.sleep(0.01)
            assert app._status()["hooks"] == app._parts.hooks.status()
            assert app._parts.hooks.status()[1]["waiting"] == 2
            assert [one.code for one in app._parts.hooks.problems()] == ["hook.waiting"]
        types = [json.loads(body)["type"] for *_, body in receiver.asked]
    assert types == ["server.ready", "door.opened", "server.ending"]


def test_what_fails_is_seen_by_its_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faults name the right part, and the queue's length is counted."""
    room = {"livekit": "wss://rooms.example", "room": "a", "api_key": "k", "api_secret": "s" * 32}
    tables = {
        "camera": [{"name": "Arm", "source": "testcard"}],
        "gauges": [{"name": "amps", "warn_above": 5.0}],
        "publish": [room],
    }
    app = _app(tables)
    problems = {
        "camera": Sentence("camera.silent"),
        "camera Arm": Sentence("picture.silent"),
        "microphone": Sentence("microphone.silent"),
    }
    monkeypatch.setattr(SourceThread, "problem", property(lambda one: problems[one._name]))
    monkeypatch.setattr(Tunnel, "problem", Sentence("door.away"))
    monkeypatch.setattr(Turns, "queue", (4, 5, 6))
    state = RobotState(connected=True, battery_fraction=0.1, gauges={"amps": 7.0})
    monkeypatch.setattr(SimulatedRobot, "state", lambda _: state)
    app._parts.control.step(SystemClock().now_s())
    seen = app._seen()
    app._parts.control.stop()
    assert (seen.is_open, seen.waiting, seen.battery_fraction) == (True, 3, 0.1)
    assert seen.faults == {
        ("camera", None): "camera.silent",
        ("camera", "Arm"): "picture.silent",
        ("microphone", None): "microphone.silent",
        ("gauge", "amps"): "warn",
        ("room", "1"): "lost",
        ("tunnel", None): "door.away",
    }


async def test_nothing_is_recorded_unless_configured(state_folder: Path) -> None:
    """Without recording, no folder is created, and nothing is encoded that nobody watches."""
    app = _app()
    async with started(app):
        assert app._parts.pipelines.video.wanted == []
        assert app._status()["tape"] is None
    assert not (state_folder / "tape").exists()
