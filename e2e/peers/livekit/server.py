"""LiveKit's own process: its configuration, its start and its end."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from dataclasses import dataclass
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any, Final, NoReturn, TextIO

from e2e.harness.child import kill
from e2e.harness.toml import merged
from e2e.harness.wait import answers, eventually
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

    from e2e.peers.livekit.tokens import Key

START_WITHIN_S: Final = 30.0


@dataclass(frozen=True, slots=True)
class Ports:
    """Where LiveKit listens; the defaults are its own."""

    signal: int = 7880
    media_tcp: int = 7881
    """For browsers that UDP does not reach, as in every installation."""
    media_udp: int = 7882


def settings(
    address: str, ports: Ports, key: Key, *, is_by_default: bool = True, **more: Any
) -> dict[str, Any]:
    """Return LiveKit's configuration: on this address only, without any outside server.

    Unless `is_by_default`, it has LiveKit's preset for teleoperation; `more` is merged into it.
    """
    # https://docs.livekit.io/robotics/media/performance/low-latency/playout-delay/
    preset = {"room": {"playout_delay": {"enabled": True, "min": 0, "max": 10}}}
    tree = {
        "port": ports.signal,
        "bind_addresses": [address],
        "keys": {key.name: key.secret},
        "rtc": {
            "udp_port": ports.media_udp,
            "tcp_port": ports.media_tcp,
            "node_ip": address,
            "use_external_ip": False,
            "enable_loopback_candidate": ip_address(address).is_loopback,
            "ips": {"includes": [f"{address}/32"]},
        },
        **({} if is_by_default else preset),
    }
    return merged(tree, more)


class LiveKit:
    """One server; it logs to `log`, or to standard error. `more` is as in `settings`."""

    def __init__(
        self,
        program: Path,
        address: str,
        ports: Ports,
        key: Key,
        *,
        is_by_default: bool = True,
        log: TextIO | None = None,
        **more: Any,
    ) -> None:
        self.url = f"http://{address}:{ports.signal}"
        self._program = program
        # In a file, because a list of processes would show its secret; JSON is valid YAML.
        told = settings(address, ports, key, is_by_default=is_by_default, **more)
        self._environment = {**os.environ, "LIVEKIT_CONFIG": json.dumps(told)}
        self._log = log
        self._process: Process | None = None

    async def start(self) -> None:
        """Return when it answers. Raises `MeasureError` if it cannot be started or ends."""
        try:
            self._process = await asyncio.create_subprocess_exec(
                self._program,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=self._log or sys.stderr,
                stderr=self._log,
                env=self._environment,
                start_new_session=True,  # Ctrl-C is for us alone: we end it when we are ready
            )
        except OSError as error:
            raise MeasureError(f"{self._program} does not start: {error.strerror}") from error
        await eventually(self._answers, f"LiveKit answers at {self.url}", within_s=START_WITHIN_S)

    async def fails(self) -> NoReturn:
        """Wait until the process has ended, and raise `MeasureError`."""
        status = await self._running.wait()
        raise MeasureError(f"LiveKit ended with status {status}; its log says why")

    async def kill(self) -> None:
        """End it as a power cut does; safe to call twice."""
        await kill(self._process)

    def freeze(self) -> None:
        """Stop it until `thaw`, like a machine that hangs."""
        self._running.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """Let it continue."""
        self._running.send_signal(signal.SIGCONT)

    @property
    def pid(self) -> int:
        return self._running.pid

    @property
    def _running(self) -> Process:
        assert self._process is not None, "it was not started"
        return self._process

    async def _answers(self) -> bool:
        if (status := self._running.returncode) is not None:
            raise MeasureError(f"LiveKit ended at its start with status {status}; see its log")
        return await answers(self.url)
