"""From `wax new-driver` to a robot that moves, as the walk-through has it, command by command."""

from __future__ import annotations

import asyncio
import contextlib
import re
import socket
import threading
from typing import TYPE_CHECKING

import pytest
from tests.commands.new_driver.json_rover import JsonRover
from tests.commands.new_driver.walk_through import (
    Environment,
    commands,
    own_lines,
    python_lines,
    with_own_lines,
)
from tests.free_port import free_port

from wax.commands.proof.remote import RemoteOperator
from wax.session.proof_runner import NOT_ALL

if TYPE_CHECKING:
    import subprocess
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]

OWN_LINES = 30
MAKE_IT, TRY_IT, DRIVE_IT = commands()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """Type the first commands, up to the tests."""
    environment = Environment(tmp_path_factory.mktemp("walk"))
    for line in MAKE_IT[:-1]:
        environment.type(line)
    return environment


@pytest.fixture
def rover() -> Iterator[JsonRover]:
    rover = JsonRover()
    yield rover
    rover.close()


class Shown:
    """The newest line that a program prints."""

    def __init__(self, program: subprocess.Popen[str]) -> None:
        self.line = ""
        self._program = program
        self._thread = threading.Thread(target=self._read, name="reads what is shown")
        self._thread.start()

    @property
    def moves(self) -> bool:
        return bool(self.line) and self.line != "+0.00 m/s, +0.00 rad/s"

    def close(self) -> None:
        self._program.kill()
        self._program.wait()
        self._thread.join()

    def _read(self) -> None:
        assert self._program.stdout is not None
        with self._program.stdout as lines:
            for line in lines:
                self.line = line.strip()


@contextlib.asynccontextmanager
async def served(made: Environment, line: str, folder: Path) -> AsyncIterator[RemoteOperator]:
    """Type the command that serves the robot, and connect an operator without a browser."""
    port = free_port()
    server = made.start(line, "--host", "127.0.0.1", "--port", str(port), "--udp-port", "0")
    operator = RemoteOperator(folder / "operator.log")
    try:
        assert server.stdout is not None
        for said in iter(server.stdout.readline, ""):
            if "Ctrl-C stops" in said:
                break
        await operator.start(f"http://127.0.0.1:{port}")
        yield operator
    finally:
        await operator.kill()
        server.terminate()
        await asyncio.to_thread(server.wait)
        assert server.stdout is not None
        server.stdout.close()


async def until(so: Callable[[], bool], within_s: float) -> bool:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(within_s):
            while not so():  # noqa: ASYNC110 - what is waited for has no event
                await asyncio.sleep(0.01)
    return so()


async def drive(operator: RemoteOperator, moves: Callable[[], bool]) -> None:
    """Join, and press until the robot moves."""
    operator.send("join")
    assert await until(lambda: operator.state.drives, 20), operator.state
    for _ in range(20):
        operator.send("neutral")
        await asyncio.sleep(0.4)
        operator.send("drive")
        if await until(moves, 2):
            return
    raise AssertionError(f"the robot does not move: {operator.state}")


@pytest.mark.full
def test_the_package_passes_its_own_tests(made: Environment) -> None:
    """As written it keeps every promise, and neither ruff nor mypy has anything to say."""
    said = made.type(MAKE_IT[-1], "-q", "-n", "4")
    assert re.search(r"^(\d+) passed in", said, re.MULTILINE), said
    for check in ("ruff check", "ruff format --check", "mypy"):
        made.type(check)


@pytest.mark.full
async def test_the_stand_in_is_driven(made: Environment, tmp_path: Path) -> None:
    """The robot made of software moves when an operator drives, and stands when they stop."""
    robot, serve = TRY_IT
    port = free_port(socket.SOCK_DGRAM)
    config = made.folder / "rover.toml"
    text = config.read_text(encoding="utf-8")
    shown = Shown(made.start(robot, str(port)))
    try:
        config.write_text(text.replace("port = 8888", f"port = {port}"), encoding="utf-8")
        async with served(made, serve, tmp_path) as operator:
            await drive(operator, lambda: shown.moves)
            operator.send("stop")
            assert await until(lambda: not shown.moves, 20), shown.line
    finally:
        config.write_text(text, encoding="utf-8")
        shown.close()


def test_the_hosts_own_lines_are_few() -> None:
    """What somebody writes for a robot of another kind is at most thirty lines."""
    assert 10 < python_lines(own_lines()) <= OWN_LINES


@pytest.fixture
def own(tmp_path_factory: pytest.TempPathFactory, rover: JsonRover) -> Environment:
    """Make the package anew and write the host's own lines into it."""
    environment = Environment(tmp_path_factory.mktemp("own"))
    for line in MAKE_IT[:-1]:
        environment.type(line)
    with_own_lines(environment.folder)
    config = environment.folder / "rover.toml"
    text = config.read_text(encoding="utf-8")
    theirs = 'host = "127.0.0.1"\nport = 8888\n'
    assert theirs in text
    config.write_text(text.replace(theirs, f'port = "{rover.port}"\n'), encoding="utf-8")
    return environment


def _is_ahead(left: float, right: float) -> bool:
    return left == right > 0


async def test_the_hosts_own_robot_is_driven(
    own: Environment, rover: JsonRover, tmp_path: Path
) -> None:
    """With the walk-through's own lines in it a robot on a serial port is driven, and stops."""
    async with served(own, DRIVE_IT[0], tmp_path) as operator:
        await drive(operator, lambda: _is_ahead(*rover.wheels))
        operator.send("stop")
        assert await until(lambda: not rover.moves, 20)


@pytest.mark.full
@pytest.mark.alone
def test_its_stop_is_proved(own: Environment, rover: JsonRover) -> None:
    """The last command drives it and cuts its links; what no program can cut it names.

    Neither ruff nor mypy has anything to say about the host's own lines.
    """
    for check in ("ruff check", "ruff format --check", "mypy src"):
        own.type(check)
    line = DRIVE_IT[-1]
    assert line.endswith(" prove-stop")
    record = own.folder / "record.html"
    with own.start(line, "--lifted", "--repeats", "1", "--record", str(record)) as proof:
        said, _ = proof.communicate()
    verdict = said.splitlines()[-1]
    assert verdict.startswith("Each measurable link was cut once; the robot stood within ")
    assert "Not proved: The driver process is killed; The link to the robot is cut." in verdict
    assert proof.returncode == NOT_ALL
    assert not rover.moves
