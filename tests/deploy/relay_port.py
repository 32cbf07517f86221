"""Relay to two ports of one machine, before and after `turnserver.nft`, in a network of its own.

``python -m tests.deploy.relay_port FOLDER``, in a new namespace; prints which ports were reached.
"""

from __future__ import annotations

import asyncio
import os
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from tests.deploy import test_programs_beside as beside

WAX = "198.51.100.5"
_PORTS = (8081, 8082)
_ARRIVES_S = 1.0


def _command(*words: str) -> None:
    subprocess.run(words, check=True)


async def _reached(turn_port: int) -> list[int]:
    """Send to each port by a relay of its own: coturn gives one up where the system refuses."""
    loop = asyncio.get_running_loop()
    reached = []
    for port in _PORTS:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wax:
            wax.bind((WAX, port))
            wax.setblocking(False)
            async with beside.relay(turn_port, beside.SECRET) as relay:
                await relay.send_data(b"hello", (WAX, port))
                with suppress(TimeoutError):
                    async with asyncio.timeout(_ARRIVES_S):
                        await loop.sock_recv(wax, 99)
                        reached.append(port)
    return reached


async def main(folder: Path) -> None:
    """Print the ports that were reached without the rule, and with it."""
    _command("ip", "link", "set", "lo", "up")
    _command("ip", "address", "add", f"{WAX}/32", "dev", "lo")
    rule = beside.RULE.read_text(encoding="utf-8")
    # In this namespace coturn runs as whoever runs the test.
    rule = beside.put(rule, '"turnserver"', str(os.getuid()))
    (folder / "turnserver.nft").write_text(rule)
    async with beside.coturn(folder, WAX) as (port, _):
        for file in (None, folder / "turnserver.nft"):
            if file is not None:
                _command("nft", "-f", str(file))
                _command("nft", "-f", str(file))  # as each start of coturn does
            print(*await _reached(port))  # noqa: T201  # the test reads it


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1])))
