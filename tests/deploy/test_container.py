"""The container file: its sources exist, its command is valid, and it builds."""

from __future__ import annotations

import asyncio
import datetime
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer

from wax import __main__ as command
from wax.config.settings import Settings
from wax.monitoring import alive
from wax.web.certificate import self_signed

ROOT = Path(__file__).parents[2]
FILE = ROOT / "config" / "deploy" / "Containerfile"
NO_REGISTRY: Final = re.compile(r"pinging container|lookup .* no such host|failed to resolve|i/o t")
"""The builders' messages if the base image cannot be fetched."""


def _stages() -> list[list[tuple[str, str]]]:
    """Return the instructions and their arguments, stage by stage."""
    text = FILE.read_text(encoding="utf-8")
    text = re.sub(r"(?m)^#.*\n", "", text).replace("\\\n", "")
    stages: list[list[tuple[str, str]]] = []
    for line in filter(None, map(str.strip, text.splitlines())):
        instruction, _, argument = line.partition(" ")
        if instruction == "FROM":
            stages.append([])
        stages[-1].append((instruction, argument))
    return stages


def _of(stage: list[tuple[str, str]], name: str) -> list[str]:
    return [argument for instruction, argument in stage if instruction == name]


def test_it_copies_what_is_there() -> None:
    """Every source of a COPY is in the repository, and nothing that was built here is copied."""
    copied = [one for stage in _stages() for one in _of(stage, "COPY") if "--from" not in one]
    sources = [source for one in copied for source in one.split()[:-1]]
    assert sources
    assert [source for source in sources if not (ROOT / source).exists()] == []
    ignored = (FILE.with_name("Containerfile.dockerignore")).read_text(encoding="utf-8")
    for built in ("server/wax/web/dist", "web/node_modules", "web/src/generated"):
        assert built in ignored


def test_it_runs_as_nobody_special_at_the_ports_of_the_configuration() -> None:
    """The last stage has its own user, and exposes one TCP and one UDP port, as configured."""
    run = _stages()[-1]
    names = [instruction for instruction, _ in run]
    assert _of(run, "USER") == ["wax"]
    assert names.index("USER") < names.index("ENTRYPOINT")
    tcp, udp = _of(run, "EXPOSE")[0].split()
    assert (tcp, udp) == (f"{Settings().server.port}/tcp", "8081/udp")


def test_the_command_understands_its_arguments() -> None:
    """The container's command has options that `wax` has, in the form that passes on signals."""
    run = _stages()[-1]
    arguments = command._parser().parse_args(json.loads(_of(run, "CMD")[0]))
    assert (str(arguments.config), arguments.host) == ("/etc/wax/wax.toml", "0.0.0.0")
    assert json.loads(_of(run, "ENTRYPOINT")[0]) == ["/opt/wax/bin/wax"]


@pytest.mark.parametrize("is_https", [False, True])
async def test_its_health_check_tells_a_server_from_none(tmp_path: Path, is_https: bool) -> None:
    """The command works as written, at the configured port, by HTTP or HTTPS."""
    check = _of(_stages()[-1], "HEALTHCHECK")[0]
    _, *words, config = json.loads(check[check.index("[") :])
    assert config == "/etc/wax/wax.toml"
    assert Settings().server.port == alive.PORT

    async def status(port: int) -> int:
        (tmp_path / "wax.toml").write_text(f"[server]\nport = {port}\n")
        process = await asyncio.create_subprocess_exec(
            sys.executable, *words, tmp_path / "wax.toml", stderr=asyncio.subprocess.DEVNULL
        )
        return await process.wait()

    async def healthy(_: web.Request) -> web.Response:
        return web.Response()

    application = web.Application()
    application.router.add_get("/healthz", healthy)
    made = self_signed(tmp_path, ["robot.example"], datetime.datetime.now(datetime.UTC))
    server = TestServer(application)
    await server.start_server(ssl=made.context() if is_https else None)
    port = server.port
    assert port is not None
    assert await status(port) == 0
    await server.close()
    assert await status(port) != 0


def test_what_the_server_starts_is_in_it() -> None:
    """The tunnel needs ssh, a separate program."""
    assert "openssh-client" in " ".join(_of(_stages()[-1], "RUN")).split()


def test_every_package_is_checked() -> None:
    """All that pip installs is pinned by hash or was built here."""
    built = " ".join(argument for stage in _stages() for argument in _of(stage, "RUN"))
    installs = re.findall(r"pip install([^&]*)", built)
    assert installs
    assert all("--require-hashes" in one or "--no-index" in one for one in installs)


def _builder() -> list[str] | None:
    """Return the command that builds images here, None if none works."""
    for name in ("podman", "docker", "buildah"):
        if shutil.which(name) is None:
            continue
        works = subprocess.run([name, "info"], capture_output=True, check=False, timeout=60)
        if works.returncode == 0:
            return [name, "build"]
    return None


@pytest.mark.system
@pytest.mark.full
@pytest.mark.timeout(1200)
def test_it_builds() -> None:
    """If there is a builder and its registry, the image builds."""
    builder = _builder()
    if builder is None:
        pytest.skip("there is no podman, docker or buildah that works")
    built = subprocess.run(
        [*builder, "-f", str(FILE), "-t", "wax-test", str(ROOT)],
        capture_output=True,
        text=True,
        check=False,
    )
    if built.returncode and NO_REGISTRY.search(built.stderr):
        pytest.skip("the registry of the base image cannot be reached")
    assert built.returncode == 0, built.stderr[-4000:]
