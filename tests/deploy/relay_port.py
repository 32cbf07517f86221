"""Relay to two ports of one machine, before and after `turnserver.nft`, in a network of its own.

``python -m tests.deploy.relay_port FOLDER ADDRESS``, in a new namespace; it prints which ports of
WAX at this address were reached.
"""

from __future__ import annotations

import asyncio
import os
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from aioice import stun
from tests.deploy import test_programs_beside as beside

_PORTS = (8081, 8082)
_TURN_PORT = 3478
"""A fixed port: from the ports of relays the rule lets nothing else out, not even coturn's
answers."""
_SYSTEMS_PORTS = "32768 49000"
"""The clients' ports, for the same reason: they run as the same user as coturn."""
_ARRIVES_S = 1.0


def _command(*words: str) -> None:
    subprocess.run(words, check=True)


async def _reached(turn_port: int, wax: str) -> list[int]:
    """Send to each port through a relay of its own: coturn ends a relay that the system refuses."""
    is_ipv6 = ":" in wax
    host = beside.LOOPBACK[is_ipv6]
    family = socket.AF_INET6 if is_ipv6 else socket.AF_INET
    loop = asyncio.get_running_loop()
    reached = []
    for port in _PORTS:
        with socket.socket(family, socket.SOCK_DGRAM) as line:
            line.bind((wax, port))
            line.setblocking(False)
            async with beside.relay(turn_port, beside.SECRET, host=host) as relay:
                with suppress(stun.TransactionFailed):
                    await relay.send_data(b"hello", (f"{wax}1", port))
                    print("another address was reached")  # noqa: T201
                await relay.send_data(b"hello", (wax, port))
                with suppress(TimeoutError):
                    async with asyncio.timeout(_ARRIVES_S):
                        await loop.sock_recv(line, 99)
                        reached.append(port)
    return reached


async def main(folder: Path, wax: str) -> None:
    """Print the ports that were reached without the rule, and with it."""
    _command("ip", "link", "set", "lo", "up")
    _command("ip", "address", "add", wax, "dev", "lo", *(["nodad"] if ":" in wax else []))
    rule = beside.RULE.read_text(encoding="utf-8")
    # In this namespace coturn runs as the user who runs the test.
    rule = beside.put(rule, '"turnserver"', str(os.getuid()))
    (folder / "turnserver.nft").write_text(rule)
    async with beside.coturn(folder, wax, _TURN_PORT) as (port, _):
        for file in (None, folder / "turnserver.nft"):
            if file is not None:
                _command("nft", "-f", str(file))
                _command("nft", "-f", str(file))  # as each start of coturn does
            print(*await _reached(port, wax))  # noqa: T201  # the test reads it


if __name__ == "__main__":
    Path("/proc/sys/net/ipv4/ip_local_port_range").write_text(_SYSTEMS_PORTS)
    asyncio.run(main(Path(sys.argv[1]), sys.argv[2]))
