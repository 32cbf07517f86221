"""The wheel that a host installs, in an environment that has nothing of this folder."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import aiohttp
import pytest
from tests.deploy.running import answers, serving
from tests.free_port import free_port

from wax import __version__

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]

ROOT = Path(__file__).parents[2]
UV = Path(sys.executable).with_name("uv")


def _run(*command: str | Path, folder: Path = ROOT) -> str:
    """Return a command's output; nothing of this folder is on Python's path."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build it with the installed tools, in the locked versions."""
    folder = tmp_path_factory.mktemp("wheel")
    _run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder)
    (made,) = folder.glob("*.whl")
    return made


def test_it_holds_the_page_and_no_test(wheel: Path) -> None:
    """It has the page, its compressed copies and the types, but no tests and build stamps."""
    assert wheel.name == f"wax_teleop-{__version__}-py3-none-any.whl"
    names = zipfile.ZipFile(wheel).namelist()
    assert {"wax/web/dist/index.html", "wax/py.typed"} <= set(names)
    assert "wax/robot/simulated/answers/ada_1.opus" in names
    assert any(re.fullmatch(r"wax/web/dist/assets/.*\.js\.gz", name) for name in names)
    tops = {name.split("/")[0] for name in names}
    assert tops == {"wax", f"wax_teleop-{__version__}.dist-info"}
    ours = [name for name in names if "/new_driver/template/" not in name]
    assert not [name for name in ours if ".sources" in name or "test_" in name]


@pytest.mark.full
async def test_it_serves_where_nothing_else_is(wheel: Path, tmp_path: Path) -> None:
    """In a fresh environment it prints its version and its help, serves its page, and ends well."""
    _run(sys.executable, "-m", "venv", "--without-pip", tmp_path / "fresh")
    fresh = tmp_path / "fresh" / "bin"
    install = (UV, "--no-config", "pip", "install", "-q", "--python", fresh / "python")
    _run(*install, "--require-hashes", "-r", ROOT / "requirements.lock")
    _run(*install, "--no-deps", "--offline", wheel)
    wax = fresh / "wax"
    assert _run(wax, "--version", folder=tmp_path).strip() == f"wax {__version__}"
    assert "prove-stop" in _run(wax, "--help", folder=tmp_path)
    config = tmp_path / "wax.toml"
    config.write_text("")
    port = free_port()
    async with serving(config, port, command=(str(wax),)) as server:
        await answers(port, server)
        async with aiohttp.ClientSession() as http, http.get(f"http://127.0.0.1:{port}/") as page:
            assert "<title>" in await page.text()
        server.send_signal(signal.SIGTERM)
        assert await asyncio.wait_for(server.wait(), 10) == 0
