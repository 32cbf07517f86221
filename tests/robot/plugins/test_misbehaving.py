"""Whatever a plug-in does, picture, sound, other people's pages and the status still work."""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import TYPE_CHECKING, Any, Final

import aiohttp
import psutil
import pytest

from wax.client import Client
from wax.client.host import become_host
from wax.commands.proof.server import ServerUnderProof

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.client.sdp import Kind

pytestmark = [pytest.mark.system, pytest.mark.timeout(120)]

_PATIENCE_S: Final = 45.0
_MORE: Final[dict[Kind, int]] = {"audio": 11, "video": 6}
"""More sound packets and pictures than were already under way."""

_CONFIG: Final = """
[server]
state_dir = "{folder}/state"
max_offers_per_address_hz = 100.0
[network]
udp_port = 0
[records]
enabled = false
[video]
source = "{video}"
width = 160
height = 120
fps = 15.0
renditions = [{{ width = 160, height = 120, fps = 15.0, bitrate_bps = 100000 }}]
[audio]
source = "testcard"
[robot]
driver = "tests.robot.plugins.{driver}"
[[camera]]
name = "beside"
source = "testcard"
width = 160
height = 120
fps = 5.0
renditions = [{{ width = 160, height = 120, fps = 5.0, bitrate_bps = 50000 }}]
"""


class Server(ServerUnderProof):
    """A real server with one plug-in, in a process of its own."""

    def __init__(self, folder: Path, driver: str, video: str) -> None:
        super().__init__(folder, _CONFIG.format(folder=folder, driver=driver, video=video))
        self.folder = folder
        self.http: aiohttp.ClientSession

    async def robot(self) -> dict[str, Any] | None:
        """Answer as soon as the server does, whatever its robot."""
        with contextlib.suppress(aiohttp.ClientError, OSError):
            async with self.http.get(f"{self.url}/healthz") as response:
                return {} if response.ok else None
        return None

    async def status(self) -> dict[str, Any]:
        async with self.http.get(f"{self.url}/api/status") as response:
            response.raise_for_status()
            found: dict[str, Any] = await response.json()
            return found

    @property
    def has_ended(self) -> bool:
        assert self._process is not None
        return self._process.returncode is not None

    async def sentence(self, says: str, where: str) -> None:
        """Wait for this problem in the status; `where` is ``robot`` or ``camera``."""
        said: object = None
        end_s = time.monotonic() + _PATIENCE_S
        while time.monotonic() < end_s and not self.has_ended:
            status = await self.status()
            said = (status["robot"] if where == "robot" else status["streams"]["video"])["problem"]
            if says in str(said):
                return
            await asyncio.sleep(0.05)
        raise AssertionError(f"{said!r}, not {says!r}; {self.last_line()}")

    async def end(self) -> int:
        """End it as a service manager does; return its exit status."""
        assert self._process is not None
        children = psutil.Process(self._process.pid).children(recursive=True)
        self._process.terminate()
        code = await asyncio.wait_for(self._process.wait(), 10.0)
        _, left = await asyncio.to_thread(psutil.wait_procs, children, 3.0)
        assert left == [], "a process has outlived its server"
        return code


@contextlib.asynccontextmanager
async def serving(folder: Path, driver: str, video: str = "testcard") -> AsyncIterator[Server]:
    server = Server(folder, driver, video)
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as server.http:
        await server.start()
        try:
            await become_host(server.http, server.url, folder / "state")
            yield server
        finally:
            await server.kill()


async def goes_on(server: Server, *, picture: bool = True) -> None:
    """Check that the page is served, a newcomer is sent media, and the other camera delivers."""
    async with server.http.get(server.url) as page:
        assert page.ok
    async with asyncio.timeout(_PATIENCE_S), Client(server.url) as viewer:
        kinds: tuple[Kind, ...] = ("audio", "video") if picture else ("audio",)
        for kind in kinds:
            await viewer.media.arrived[kind].wait()
            enough = viewer.media.counts(kind).frames + _MORE[kind]
            while viewer.media.counts(kind).frames < enough:  # noqa: ASYNC110  # nothing to await
                await asyncio.sleep(0.05)
        assert await viewer.pongs(5.0)
        while not (camera := (await server.status())["cameras"][0])["captured_fps"]:  # noqa: ASYNC110
            await asyncio.sleep(0.05)
    assert camera["problem"] is None
    assert not server.has_ended


ENDED = "The driver process has ended ("
BUILT = "The robot's driver cannot be loaded; retrying. robot.driver: "
HANGS = "The driver process does not answer; restarting it."
NO_ANSWER = "The robot does not answer."
SLOW = pytest.mark.full
"""A test that takes the 20 s allowed for loading a plug-in, or much resembles another."""


@SLOW
@pytest.mark.parametrize(
    ("driver", "says"),
    [
        ("raises_on_import:Robot", BUILT),
        ("exits_on_import:Robot", ENDED + "status 3"),
        ("hangs_on_import:Robot", HANGS),
        ("misbehaving:RaisesInConstructor", BUILT),
        ("misbehaving:RubbishLimits", BUILT),
        ("misbehaving:RubbishKind", BUILT),
        ("misbehaving:RaisesInLimits", BUILT),
        ("misbehaving:RaisesInOpen", ENDED + "status 1"),
        ("misbehaving:HangsInOpen", HANGS),
        ("misbehaving:RaisesInApply", NO_ANSWER),
        ("misbehaving:HangsInApply", HANGS),
        ("misbehaving:HangsWithInterpreter", HANGS),
        ("misbehaving:RaisesInState", NO_ANSWER),
        ("misbehaving:RubbishState", NO_ANSWER),
        ("misbehaving:HangsInState", HANGS),
        ("misbehaving:HangsInClose", HANGS),
        ("misbehaving:LeaksThreads", "uses more and more of the machine ("),
        ("misbehaving:LeaksFiles", NO_ANSWER),
        ("misbehaving:Exits", ENDED + "status 3"),
        ("misbehaving:KillsItself", ENDED + "signal 9"),
        ("misbehaving:TakesSignals", HANGS),
    ],
)
async def test_a_driver_breaks_nothing_but_itself(tmp_path: Path, driver: str, says: str) -> None:
    """The status reports the fault; everything else keeps working, and ends in order."""
    async with serving(tmp_path, driver) as server:
        await server.sentence(says, "robot")
        await goes_on(server)
        assert await server.end() == 0


@pytest.mark.parametrize("driver", [pytest.param("RaisesInStop", marks=SLOW), "HangsInStop"])
async def test_a_driver_that_does_not_stop_is_held_or_ended(tmp_path: Path, driver: str) -> None:
    """Stop is retried or the process replaced; everything else works, its camera too."""
    async with serving(tmp_path, f"misbehaving:{driver}", "robot") as server:
        await server.sentence("None", "robot")
        async with Client(server.url) as viewer:
            await viewer.post("/api/stop", {})
            end_s = time.monotonic() + _PATIENCE_S
            counted = 0.0
            while not counted and time.monotonic() < end_s:
                robot = (await server.status())["robot"]
                counted = robot["driver_failures"] + robot["driver_restarts"]
                await asyncio.sleep(0.05)
            assert counted
        await goes_on(server)
        assert await server.end() == 0


@SLOW
async def test_a_driver_that_prints_without_end_fills_no_log(tmp_path: Path) -> None:
    """It keeps working, and the log gets some of its lines."""
    async with serving(tmp_path, "misbehaving:PrintsMegabytes") as server:
        await server.sentence("None", "robot")
        await goes_on(server)
        assert await server.end() == 0
    assert (tmp_path / "server.log").stat().st_size < 300_000


@SLOW
@pytest.mark.parametrize(
    ("driver", "says"),
    [
        ("CameraRaises", "The camera failed: no lens"),
        ("CameraHangs", "The camera delivers nothing; check that it is connected."),
        ("CameraIsNone", "The camera failed: "),
        ("CameraIsOdd", "The camera delivers something other than a table of bytes; it must be"),
        ("CameraExits", "The process of the robot's camera and sound has ended (status 5"),
        ("CameraLocks", "The robot's camera and sound are starting."),
        ("CameraLeaks", "uses more and more of the machine ("),
    ],
)
async def test_a_robots_camera_breaks_nothing_but_its_picture(
    tmp_path: Path, driver: str, says: str
) -> None:
    """The status reports the fault, and the robot stays connected."""
    async with serving(tmp_path, f"misbehaving:{driver}", "robot") as server:
        async with asyncio.timeout(_PATIENCE_S):  # a camera may be starting until then
            while not (await server.status())["robot"]["connected"]:  # noqa: ASYNC110
                await asyncio.sleep(0.05)
        await server.sentence(says, "camera")
        await goes_on(server, picture=False)
        robot = (await server.status())["robot"]
        assert (robot["connected"], robot["problem"]) == (True, None)
        assert robot["driver_restarts"] == 0
        assert await server.end() == 0
