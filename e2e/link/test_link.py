"""The real link: packets pass as the profile says, and whatever happens, nothing is left behind."""

from __future__ import annotations

import asyncio
import json
import math
import os
import signal
import subprocess
import sys
from asyncio.subprocess import PIPE
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import psutil
import pytest
import pytest_asyncio
from tests.link.errors import LinkError
from tests.link.model import Direction
from tests.link.profile import load

from e2e.harness.wait import until
from e2e.link import Link, leftovers, namespace
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator

ROOT = Path(__file__).parents[2]

BURST_BYTES = 300
SEND = """
import json, socket, sys, time
from e2e.link.forwarder import be_first
be_first()
own, other, trains = sys.argv[1:]
with socket.socket(type=socket.SOCK_DGRAM) as link:
    link.bind((own, 7000))
    sent, next_s = [], time.monotonic()
    for count, gap_s, size in json.loads(trains):
        for _ in range(count):
            time.sleep(max(0.0, next_s - time.monotonic()))
            sent.append((time.monotonic(), size))
            link.sendto((len(sent) - 1).to_bytes(4, "big") + bytes(size - 32), (other, 7000))
            next_s += gap_s
        time.sleep(0.5)
        next_s = time.monotonic()
print(json.dumps(sent))
"""
RECEIVE = """
import json, socket, sys, time
from e2e.link.forwarder import be_first
be_first()
with socket.socket(type=socket.SOCK_DGRAM) as link:
    link.bind((sys.argv[1], 7000))
    print(flush=True)
    came = []
    link.settimeout(10)
    try:
        while True:
            data = link.recv(2048)
            came.append((int.from_bytes(data[:4], "big"), time.monotonic()))
            link.settimeout(2.5)
    except TimeoutError:
        print(json.dumps(came))
"""
OWNER = """
import asyncio, sys
from e2e.link import Link

async def main():
    async with Link("lan") as link:
        # A child that has left its parent, as a browser's processes do, and one that is stubborn.
        await link.server.spawn(["sh", "-c", "setsid sleep 4711 & exec setsid sleep 4712"])
        await link.browser.spawn(["sh", "-c", "trap '' TERM; while :; do sleep 4713; done"])
        await asyncio.sleep(0.3)
        print(link._forwarder.pid, flush=True)
        await asyncio.sleep(60)

asyncio.run(main())
"""


@pytest_asyncio.fixture(loop_scope="session")
async def link() -> AsyncIterator[Link]:
    async with Link("lan") as link:
        yield link


@pytest.fixture
def owner(link: Link) -> Iterator[Callable[[], tuple[subprocess.Popen[str], int]]]:
    """Start processes that make a link, if one can be made; yield each and its forwarder's id."""
    started: list[subprocess.Popen[str]] = []

    def start() -> tuple[subprocess.Popen[str], int]:
        process = subprocess.Popen(
            [sys.executable, "-c", OWNER], cwd=ROOT, stdout=subprocess.PIPE, text=True
        )
        started.append(process)
        assert process.stdout is not None
        return process, int(process.stdout.readline())

    yield start
    for process in started:
        process.kill()
        process.wait()  # do not wait for its output: its leftovers may hold that open
        assert process.stdout is not None
        process.stdout.close()


def made_by(pid: int) -> set[int]:
    """Return the processes that carry the mark of a link's owner, and the forwarder among them."""
    found = set()
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.environ().get(leftovers.MARK, "").startswith(f"{pid}:"):
                found.add(process.pid)
    return found


async def gone(pid: int, within_s: float) -> None:
    await until(lambda: not made_by(pid), "nothing is left", within_s=within_s)


async def test_the_ends_see_each_other_only(link: Link) -> None:
    """An end has `lo` and the link, no other interface, and not the address of the machine."""
    look = await link.browser.spawn(
        [namespace.tool("ip", "iproute2"), "-brief", "address"], stdout=PIPE
    )
    out, _ = await look.communicate()
    rows = [line.split() for line in out.decode().splitlines()]
    assert [row[0] for row in rows] == ["lo", "wax0"]
    assert rows[1][2:] == ["10.77.0.2/24"]


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
async def test_nothing_is_left_however_the_owner_ends(owner: Any, how: signal.Signals) -> None:
    """After Ctrl-C, SIGTERM or a kill, the link and all its processes end in 3 s."""
    process, forwarder = owner()
    assert forwarder in made_by(process.pid)
    assert len(made_by(process.pid)) >= 5
    process.send_signal(how)
    process.wait(5)
    await gone(process.pid, within_s=3)


def killed(process: subprocess.Popen[str], forwarder: int) -> int:
    """Kill an owner and its forwarder, which then cannot clean up; return the owner's id."""
    os.kill(forwarder, signal.SIGSTOP)
    process.kill()
    process.wait()
    os.kill(forwarder, signal.SIGKILL)
    return process.pid


async def test_the_next_link_clears_what_a_killed_one_left(owner: Any) -> None:
    """If forwarder and owner are both killed, their programs run until the next link starts."""
    pid = killed(*owner())
    assert made_by(pid)
    async with Link("lan"):
        await gone(pid, within_s=5)


async def test_one_that_ends_while_we_look_spares_no_other(
    owner: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that ends just before its namespace is opened does not stop the cleaning up."""
    pid = killed(*owner())
    real, too_late = os.open, list[str]()

    def open_or_fail(path: str, *rest: Any, **more: Any) -> int:
        if not too_late:
            too_late.append(path)
            raise ProcessLookupError(path)
        return real(path, *rest, **more)

    with monkeypatch.context() as patched:
        patched.setattr(os, "open", open_or_fail)
        leftovers.end_stale()
    assert too_late[0].startswith("/proc/")
    await gone(pid, within_s=5)


async def test_a_killed_forwarder_is_told_and_cleared() -> None:
    """Without its forwarder the link says so in one sentence, and leaves nothing behind either."""
    async with Link("lan") as link:
        program = await link.server.spawn(["sleep", "4714"])
        assert link._forwarder is not None
        link._forwarder.kill()
        await link._forwarder.wait()
        with pytest.raises(LinkError, match=r"the link (has ended|does not answer)"):
            await link.statistics()
    assert program.returncode is not None


async def test_a_stranger_is_left_alone() -> None:
    """Cleaning up ends nothing outside our namespaces, not even with another link's mark."""
    env = {**os.environ, leftovers.MARK: "1:0"}
    stranger = await asyncio.create_subprocess_exec("sleep", "30", env=env)
    async with Link("lan"):
        assert stranger.returncode is None
    assert stranger.returncode is None
    stranger.kill()
    await stranger.wait()


@pytest.mark.parametrize("name", ["modem-56k", "wifi-bad", "stalls"])
async def test_the_link_is_what_its_profile_says(name: str) -> None:
    """Real packets arrive when, and only if, the model says so, which has tests of its own.

    A few at first, so that the random choices are the same; then more than the rate, for rate and
    queue.
    """
    settings = load(name)
    rate_bps = settings.down.rate_bps or 0
    burst = round(1.5 * rate_bps / 8 / BURST_BYTES * 2)
    trains = [(100, 0.02, 60), (burst, 2.0 / burst, BURST_BYTES)]
    async with Link(settings) as link:
        here, there = link.browser, link.server
        receives = await here.spawn_python(["-c", RECEIVE, here.address], stdout=PIPE)
        assert receives.stdout is not None
        await receives.stdout.readline()
        sends = await there.spawn_python(
            ["-c", SEND, there.address, here.address, json.dumps(trains)], stdout=PIPE
        )
        sent = json.loads((await sends.communicate())[0])
        came = dict(json.loads((await receives.communicate())[0]))
        is_first = (await link.statistics()).real_time
        model = Direction(settings.down, seed=settings.seed, way="down", start_s=link.start_s)
    for number, (at_s, size) in enumerate(sent):
        model.arrive(number.to_bytes(4, "big") + bytes(size - 4), at_s)
    due = {int.from_bytes(packet[:4], "big"): at_s for at_s, packet in model.due(math.inf)}
    few = trains[0][0]
    assert {number for number in came if number < few} == {n for n in due if n < few}
    assert len(came) == pytest.approx(len(due), abs=max(3, 0.03 * len(due)))
    if is_first:  # otherwise other programs run before it, so times mean little
        late_ms = [1000 * (came[number] - due[number]) for number in came if number < few]
        assert sum(-0.1 <= late < 5 for late in late_ms) > 0.95 * len(late_ms)
        assert max(came.values()) == pytest.approx(max(due.values()), abs=0.1)


def test_a_missing_command_is_one_sentence() -> None:
    """A command that is not installed is named with the package that brings it."""
    with pytest.raises(NotRunError, match=r"^there is no command ipp; install the package x$"):
        namespace.tool("ipp", "x")
