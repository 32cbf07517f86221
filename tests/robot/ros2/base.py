"""Robots' bases in processes of their own, and the commands that they have received."""

from __future__ import annotations

import fcntl
import itertools
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections import deque
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import gettempdir
from typing import TYPE_CHECKING, Any, Final

import pytest

from wax.driver.interface import Twist

if TYPE_CHECKING:
    from collections.abc import Callable

_ROOT: Final = Path(__file__).parents[3]
_SOURCE: Final = Path(__file__).with_name("fastdds_base.cpp")
_BUILT: Final = _ROOT / ".cache" / "fastdds_base"
_COUNT: Final = itertools.count(29 * os.getpid())
_OWN: Final = deque[ExitStack]()
_MOST_OWN: Final = 12


def own_domain() -> int:
    """Return a DDS domain that no other test on this machine uses now.

    It belongs to the process that has locked its file; each keeps its last few.
    """
    while True:
        domain = 1 + next(_COUNT) % 230
        with suppress(OSError), ExitStack() as held:  # another process has it
            file = held.enter_context(Path(gettempdir(), f"wax-test-domain-{domain}").open("a"))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _OWN.append(held.pop_all())
            if len(_OWN) > _MOST_OWN:
                _OWN.popleft().close()
            return domain


@dataclass(frozen=True, slots=True)
class Told:
    """A command: its arrival (`time.monotonic`), its stamp and the sum of what must be zero."""

    at_s: float
    stamp_ns: int
    twist: Twist
    others: float


class CommandLog:
    """The commands that a robot has received, in a thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._told: list[Told] = []

    def told(self) -> list[Told]:
        """Return the commands so far."""
        with self._lock:
            return list(self._told)

    def forget(self) -> list[Told]:
        with self._lock:
            told, self._told = self._told, []
            return told


class Base(CommandLog):
    """A base that takes commands, by CycloneDDS or Fast DDS; it can restart."""

    def __init__(
        self,
        domain: int,
        *,
        topic: str = "/cmd_vel",
        kind: str = "twist",
        reliability: str = "reliable",
        fast: bool = False,
    ) -> None:
        program = (
            [str(fastdds_base())] if fast else [sys.executable, "-m", f"{__package__}.cyclone_base"]
        )
        self._command = [*program, str(domain), topic, kind, reliability]
        self._is_fast = fast
        self._process: subprocess.Popen[str] | None = None
        super().__init__()
        self._lines: list[str] = []

    def start(self) -> Base:
        self._lines = []
        self._process = subprocess.Popen(
            self._command,
            cwd=_ROOT,
            env=os.environ | {"PYTHONPATH": os.pathsep.join((str(_ROOT), str(_ROOT / "server")))},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        threading.Thread(target=self._read, args=(self._process,), daemon=True).start()
        self.until(lambda: "ready" in self._lines, 20.0)
        return self

    def end(self) -> None:
        """End it as a node is shut down; safe to call twice."""
        process, self._process = self._process, None
        if process is not None:
            assert process.stdin is not None
            process.stdin.close()
            process.wait(10)

    def say(self, *message: Any) -> None:
        """Publish ``TYPE, TOPIC, {…}``."""
        self._write(json.dumps(message))

    def say_odometry(self, *numbers: float) -> None:
        """Publish x, y, the quaternion's z and w, v and ω from the base on Fast DDS."""
        self._write("odometry " + " ".join(map(str, numbers)))

    def promise(self, node: str, name: str, value: float) -> None:
        """Answer requests for this parameter of a node."""
        if self._is_fast:
            self._write(f"parameter {node} {name} {value}")
        else:
            self.say("parameter", node, name, value)

    def until(self, enough: Callable[[], object], within_s: float = 5.0) -> None:
        end_s = time.monotonic() + within_s
        while not enough():
            assert time.monotonic() < end_s, (self._lines[-5:], self.told()[-5:])
            time.sleep(0.002)

    def _write(self, line: str) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                word, *numbers = line.split()
                with self._lock:
                    if word != "twist":
                        self._lines.append(line.strip())
                        continue
                    at_ns, stamp_ns, linear, angular, lateral, others = numbers
                    twist = Twist(float(linear), float(angular), float(lateral))
                    self._told.append(Told(int(at_ns) / 1e9, int(stamp_ns), twist, float(others)))


def fastdds_base() -> Path:
    """Build the base on Fast DDS; without its library, skip the test, or fail it in CI."""
    compiler = shutil.which("g++")
    if compiler is None or not Path("/usr/include/fastdds/dds").is_dir():
        sentence = "Fast DDS is missing; type: sudo apt-get install -y g++ libfastrtps-dev"
        if os.environ.get("CI"):
            pytest.fail(sentence)
        pytest.skip(sentence)
    if not _BUILT.exists() or _BUILT.stat().st_mtime < _SOURCE.stat().st_mtime:
        _BUILT.parent.mkdir(exist_ok=True)
        half = _BUILT.with_suffix(f".{os.getpid()}")
        libraries = ["-lfastrtps", "-lfastcdr"]
        subprocess.run(
            [compiler, "-std=c++17", "-O1", "-o", str(half), str(_SOURCE), *libraries], check=True
        )
        half.replace(_BUILT)
    return _BUILT
