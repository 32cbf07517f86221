"""Keeps the tunnel open: starts ssh, reads its messages, restarts it; in threads of its own.

Starting a program may wait for a disk, and a name lookup for a server that does not answer: neither
may block the event loop.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import threading
from collections import deque
from dataclasses import dataclass
from typing import IO, TYPE_CHECKING, Final

import structlog

from wax import state_dir
from wax.door import ssh
from wax.door.attempts import Attempts
from wax.door.page import check_page
from wax.errors import WaxError, reason_of
from wax.machine import python_module
from wax.named_file import read_bytes, secret_file
from wax.rtc.stun_query import StunError, public_address, split
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from wax.clock import Clock
    from wax.config.door import DoorSettings
    from wax.config.settings import Settings
    from wax.door.ssh import Way

_LOG = structlog.get_logger(__name__)

_LINES: Final = 30
_LINE_BYTES: Final = 2000
_CHECK_EVERY_S: Final = 60.0
_RECHECK_S: Final = 10.0
_FIRST_CHECK_S: Final = 1.0
_END_S: Final = 0.5
_HERE: Final = {"localhost": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}


def start(command: Sequence[str]) -> subprocess.Popen[bytes]:
    """Start ssh so that it ends with the thread that started it; raises `OSError`."""
    if shutil.which(command[0]) is None:
        raise FileNotFoundError(command[0])
    tied = shutil.which("setpriv")  # of util-linux; elsewhere the service manager ends both
    bound = [tied, "--pdeathsig", "TERM", "--", *command] if tied else list(command)
    return subprocess.Popen(
        bound,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=python_module.environment() | {"LC_ALL": "C"},  # its messages are parsed in English
        start_new_session=True,  # Ctrl-C must reach only the server, which ends ssh
    )


def lines_of(stderr: IO[bytes]) -> Iterator[str]:
    """Yield lines as they arrive, each cut at `_LINE_BYTES`; the rest of a long one is dropped."""
    is_new = True
    while piece := stderr.readline(_LINE_BYTES):
        if is_new:
            yield piece.decode(errors="replace").strip()
        is_new = piece.endswith(b"\n")


def with_key(door: DoorSettings) -> DoorSettings:
    """Return the door with a key file that ssh can read; raises `OSError` where ssh would hang."""
    key = secret_file(door.key_file)
    read_bytes(key)
    return door.model_copy(update={"key_file": str(key)})


def command(door: DoorSettings, way: Way, folder: Path, target: str) -> list[str]:
    """Write the pinned key into `folder` and return the command of ssh; raises `OSError`.

    `door` must come from `with_key`.
    """
    known_hosts = folder / "door_known_hosts"
    known_hosts.write_text(ssh.known_hosts(door), encoding="ascii")
    proxy = shlex.join([*python_module.command("wax.door.over_https"), door.host])
    return ssh.command(door, way, known_hosts, target, proxy.replace("%", "%%"))


def target(host: str, port: int) -> str:
    """Return where the page is served, as seen from this machine."""
    host = _HERE.get(host, host)
    return f"{f'[{host}]' if ':' in host else host}:{port}"


@dataclass(slots=True)
class _State:
    problem: Sentence | None = None
    page: Sentence | None = None
    relay: Sentence | None = None
    since_s: float | None = None
    """When the open tunnel was opened."""
    opened: int = 0
    failed: int = 0


class Tunnel:
    """The tunnel of `[door]`, idle without one.

    `port` returns the TCP port of the page; `run_ssh` starts ssh.
    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        port: Callable[[], int],
        run_ssh: Callable[[Sequence[str]], subprocess.Popen[bytes]] = start,
    ) -> None:
        self._door, self._server = settings.door, settings.server
        stun = [one.removeprefix("stun:") for one in settings.network.stun]
        self._stun = [one for one in stun if split(one)[0] == self._door.host]
        self._clock = clock
        self._port = port
        self._run_ssh = run_ssh
        self._attempts = Attempts()
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._state = _State()
        self._child: subprocess.Popen[bytes] | None = None
        self._threads: list[threading.Thread] = []

    @property
    def is_used(self) -> bool:
        """Whether a door is configured."""
        return bool(self._door.host)

    @property
    def problem(self) -> Sentence | None:
        """Why the page cannot be reached through the door."""
        return self._state.problem or self._state.page

    def problems(self) -> list[Sentence]:
        """Return the problems to show to the host."""
        return [one for one in (self.problem, self._state.relay) if one is not None]

    def status(self) -> dict[str, object] | None:
        """Return its state for the host's status page, None without a door."""
        if not self.is_used:
            return None
        state = self._state
        return {
            "host": self._door.host,
            "is_open": state.since_s is not None,
            "way": self._attempts.way,
            "opened": state.opened,
            "failed": state.failed,
            "problem": None if self.problem is None else str(self.problem),
        }

    # --- its threads -----------------------------------------------------------------------

    def start(self) -> None:
        """Start the threads, if there is a door."""
        if not self.is_used:
            return
        for name, work in (("tunnel", self._run), ("public page", self._watch_page)):
            # Daemons: a name server that does not answer must not delay the shutdown.
            self._threads.append(threading.Thread(target=work, name=name, daemon=True))
            self._threads[-1].start()

    def request_stop(self) -> None:
        with self._lock:
            self._closing.set()
            if self._child is not None:
                self._child.terminate()

    def stop(self) -> None:
        """End ssh at once; do not join the page's thread, which may be waiting for an answer."""
        self.request_stop()
        for thread in self._threads[:1]:
            thread.join(_END_S)
        with self._lock:
            if self._child is not None:
                self._child.kill()

    def _run(self) -> None:
        while not self._closing.is_set():
            way = self._attempts.way
            try:
                problem = self._run_once(way)
            except Exception as error:  # the page still works in the robot's own network
                _LOG.exception("the tunnel failed")
                problem = self._failed(reason_of(error))
            if self._closing.is_set():
                return
            state = self._state
            lasted_s = 0.0 if state.since_s is None else self._clock.now_s() - state.since_s
            if state.problem != problem:
                _LOG.warning("the door cannot be reached", why=str(problem), way=way)
            state.problem, state.page, state.relay, state.since_s = problem, None, None, None
            state.failed += 1
            pause_s = self._attempts.ended(problem.code.partition(".")[2], lasted_s)
            self._closing.wait(pause_s)

    def _run_once(self, way: Way) -> Sentence:
        """Run ssh until it ends; return why it ended."""
        door = self._door
        try:
            door = with_key(door)
        except OSError:
            return Sentence("tunnel.key_file", {"file": door.key_file})
        try:
            folder = state_dir.prepare(state_dir.find(self._server.state_dir))
            ssh_there = command(door, way, folder, self._target())
        except (WaxError, OSError) as error:
            return self._failed(str(error))
        with self._lock:
            if self._closing.is_set():
                return self._failed("")
            try:
                child = self._run_ssh(ssh_there)
            except FileNotFoundError:
                return Sentence("tunnel.no_ssh")
            except OSError as error:
                return self._failed(str(error))
            self._child = child
        assert child.stderr is not None
        try:
            said = self._read(child.stderr, way)
        finally:
            child.wait()
            with self._lock:
                self._child = None
            child.stderr.close()
        return ssh.problem(door, said)

    def _read(self, stderr: IO[bytes], way: Way) -> list[str]:
        """Read ssh's messages until it ends, note when the tunnel opens; return the last lines."""
        said: deque[str] = deque(maxlen=_LINES)
        for line in lines_of(stderr):
            if line.startswith(ssh.OPENED):
                self._attempts.opened()
                state = self._state
                state.problem, state.since_s = None, self._clock.now_s()
                state.opened += 1
                _LOG.info("the page can be reached through the door", host=self._door.host, way=way)
            elif not line.startswith("debug1:"):
                said.append(line)
        return list(said)

    def _watch_page(self) -> None:
        """Check regularly whether the page opens at its public address."""
        wait_s = _FIRST_CHECK_S
        while not self._closing.wait(wait_s):
            wait_s = _FIRST_CHECK_S
            since_s = self._state.since_s
            if since_s is None or not self._server.public_url:
                continue
            relay = None
            try:
                found = check_page(
                    self._server.public_url, self._clock.wall_ms() / 1000, self._target()
                )
                relay = self._ask_relay()
            except Exception as error:  # a stranger's server may answer anything
                _LOG.exception("the look at the public page failed")
                found = self._failed(reason_of(error))
            state = self._state
            if state.since_s != since_s:  # the check was of an earlier connection
                continue
            for now, before in ((found, state.page), (relay, state.relay)):
                if now is not None and now != before:
                    _LOG.warning("not all goes through the door", why=str(now))
            state.page, state.relay = found, relay
            wait_s = _RECHECK_S if found or relay else _CHECK_EVERY_S

    def _ask_relay(self) -> Sentence | None:
        """Return what is wrong with the door's STUN server, which is also its relay."""
        try:
            for one in self._stun:
                public_address(one)
        except StunError:
            return Sentence("tunnel.no_relay", {"host": self._door.host})
        return None

    def _target(self) -> str:
        return target(self._server.host, self._port())

    def _failed(self, why: str) -> Sentence:
        return Sentence("tunnel.failed", {"host": self._door.host, "why": says(why)})
