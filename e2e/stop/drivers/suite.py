"""The suite: for each driver, from the key to its wire, and how its robot stops."""

from __future__ import annotations

import asyncio
import shutil
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import NotRunError
from e2e.measure.suite import PAGE, SERVER, Case, Suite
from e2e.stop.drivers.gone import driver_killed, link_cut
from e2e.stop.drivers.key_to_wire import key_to_wire
from e2e.stop.drivers.robots import KINDS
from e2e.stop.server_gone import server_killed, server_stopped
from e2e.stop.stage import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterator

    from e2e.measure.row import Row
    from e2e.stop.drivers.robots import Kind

    Measure = Callable[[int], Coroutine[Any, Any, Row]]


def check_needs(kind: Kind) -> None:
    """Raise `NotRunError` where its counterpart cannot be here."""
    if kind.key == "ros2-fast" and not Path("/usr/include/fastdds/dds").is_dir():
        raise NotRunError("Fast DDS is missing: sudo apt-get install -y g++ libfastrtps-dev")
    if kind.key == "mavlink" and shutil.which("cargo") is None:
        raise NotRunError("the rover is built by cargo, which is missing")


def _case(kind: Kind, key: str, n: int, measure: Measure, title: str) -> Case:
    load = "" if key == "key" else str(DEFAULT)

    def run(n: int) -> list[Row]:
        check_needs(kind)
        row = asyncio.run(measure(n))
        changed = {"key": f"{kind.key}/{key}", "what": f"{kind.what}: {row.what}", "load": load}
        return [row.model_copy(update=changed)]

    return Case(f"{kind.key}/{key}", n=n, run=run, title=f"{kind.what}: {title}", quick=2)


def _cases() -> Iterator[Case]:
    for kind in KINDS:
        yield _case(kind, "key", 220, partial(key_to_wire, kind), "key presses")
        killed = partial(server_killed, end=kind.robot)
        yield _case(kind, "server-killed", 100, killed, "SIGKILL to the server")
        stopped = partial(server_stopped, end=kind.robot)
        yield _case(kind, "server-stopped", 100, stopped, "SIGSTOP to the server")
        if kind.stops_ms is not None:
            gone = partial(driver_killed, kind)
            yield _case(kind, "driver-killed", 40, gone, "SIGKILL to the driver's process")
        if kind.has_link:
            yield _case(kind, "link-cut", 100, partial(link_cut, kind), "the link is cut")


SUITE: Final = Suite(
    name="drivers",
    about="For each driver: from the key to its wire, and how its robot stops.",
    measures=(*SERVER, *PAGE),
    columns=("median", "p99", "max"),
    cases=tuple(_cases()),
    notes=(
        "Each robot is a program that knows nothing of WAX, in a process of its own: a sketch"
        " behind a pseudo-terminal, a base on CycloneDDS or Fast DDS, a rover by another MAVLink"
        " library; of rosbridge, our own server by its protocol’s text, and mock pins in the"
        " driver’s process.",
    ),
)
