"""Start a server in a process of its own, wait until it is healthy, stop it."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from e2e.bench.errors import BenchError
from e2e.bench.process import ProcessMeter, pinned
from e2e.crowd.sample import Offering

if TYPE_CHECKING:
    from types import TracebackType

Side = Literal["ours", "stock"]
SIDES: tuple[Side, ...] = ("ours", "stock")

HOST = "127.0.0.1"
START_TIMEOUT_S = 30.0
STOP_TIMEOUT_S = 10.0
STATUS_TIMEOUT_S = 10.0
ROOT = Path(__file__).resolve().parents[2]

# Turns as long as the run; whoever has left is forgotten soon, so that waiting for it is short.
TEST_CARD = """\
[video]
source = "testcard"
[audio]
source = "testcard"
[turns]
turn_s = 3600.0
grace_s = 0.5
"""


class Server:
    """`with Server("ours", core=0) as server:`; `settings` is TOML for ours, unused for stock.

    Raises `BenchError` with the end of the server's log when it does not get healthy.
    """

    def __init__(self, side: Side, core: int | None = None, settings: str = TEST_CARD) -> None:
        self.side: Side = side
        self._core = core
        self._settings = settings
        self._folder = tempfile.TemporaryDirectory(prefix="wax-bench-")
        self._log = Path(self._folder.name) / "log"
        self._process: subprocess.Popen[bytes] | None = None
        self.port = _free_port()

    def __enter__(self) -> Server:
        with self._log.open("wb") as log, pinned(self._core):
            self._process = subprocess.Popen(
                self._arguments(), stdout=log, stderr=log, stdin=subprocess.DEVNULL, cwd=ROOT
            )
        try:
            self._wait(self._process)
        except BaseException:
            self.stop()
            raise
        self.meter = ProcessMeter(self._process.pid)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.port}"

    @property
    def offering(self) -> Offering:
        return Offering(url=self.url, wax=self.side == "ours")

    def status(self) -> dict[str, Any]:
        """Ask our server about itself."""
        try:
            with urllib.request.urlopen(
                f"{self.url}/api/status", timeout=STATUS_TIMEOUT_S
            ) as answer:
                status = json.load(answer)
        except (OSError, ValueError) as error:
            raise BenchError(f"{self.url}/api/status: {error}\n{self._log_end()}") from error
        if not isinstance(status, dict):
            raise BenchError(f"{self.url}/api/status: is no JSON object")
        return status

    def stop(self) -> None:
        """Bounded, safe to call twice."""
        process, self._process = self._process, None
        if process is None:
            return
        process.terminate()
        try:
            process.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        self._folder.cleanup()

    def _arguments(self) -> list[str]:
        where = ["--host", HOST, "--port", str(self.port)]
        if self.side == "stock":
            return [sys.executable, "-m", "e2e.peers.stock", *where]
        config = Path(self._folder.name) / "bench.toml"
        config.write_text(self._settings, encoding="utf-8")
        return [sys.executable, "-m", "wax", "--config", str(config), *where]

    def _wait(self, process: subprocess.Popen[bytes]) -> None:
        deadline_s = time.monotonic() + START_TIMEOUT_S
        while time.monotonic() < deadline_s:
            if process.poll() is not None:
                raise BenchError(f"the {self.side} server ended at start:\n{self._log_end()}")
            try:
                with urllib.request.urlopen(f"{self.url}/healthz", timeout=1.0):
                    return
            except (urllib.error.URLError, OSError):
                time.sleep(0.1)
        raise BenchError(
            f"the {self.side} server was not healthy in {START_TIMEOUT_S:g} s:\n{self._log_end()}"
        )

    def _log_end(self) -> str:
        return "\n".join(self._log.read_text(encoding="utf-8", errors="replace").splitlines()[-15:])


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])
