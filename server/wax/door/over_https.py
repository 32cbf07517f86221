"""``python -m wax.door.over_https HOST``: ssh's ProxyCommand, which reaches a door by TCP 443.

The door's Caddy listens there, so this asks it by HTTP's `Upgrade` (RFC 9110, 7.8) for a connection
to sshd. The certificate is not verified: inside, sshd proves the pinned key, and a door whose
certificate has expired is easier to fix through a tunnel.
"""

from __future__ import annotations

import asyncio
import ssl
import sys
from typing import Final

PATH: Final = "/wax-door"
_READ_BYTES: Final = 65_536
_HEAD_BYTES: Final = 4096
_CONNECT_S: Final = 8.0


async def _pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(_READ_BYTES):
        writer.write(data)
        await writer.drain()


async def _standard() -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Return our standard input and output as streams."""
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    transport, protocol = await loop.connect_write_pipe(
        asyncio.streams.FlowControlMixin, sys.stdout
    )
    return reader, asyncio.StreamWriter(transport, protocol, reader, loop)


async def _run(host: str) -> None:
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    async with asyncio.timeout(_CONNECT_S):
        reader, writer = await asyncio.open_connection(host, 443, ssl=context, limit=_HEAD_BYTES)
        request = (
            f"GET {PATH} HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: ssh\r\n\r\n"
        )
        writer.write(request.encode())
        head = await reader.readuntil(b"\r\n\r\n")
    status = head.partition(b"\r\n")[0].decode(errors="replace")
    if status.split()[1:2] != ["101"]:
        raise ValueError(status)
    own_reader, own_writer = await _standard()
    # The side that ends first ends both.
    pumps = [
        asyncio.ensure_future(_pump(*one)) for one in ((reader, own_writer), (own_reader, writer))
    ]
    await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
    for pump in pumps:
        pump.cancel()
    writer.transport.abort()


def main() -> int:
    try:
        asyncio.run(_run(sys.argv[1]))
    except TimeoutError:
        print("TCP 443: timed out", file=sys.stderr)  # noqa: T201  # ssh passes it on
    except OSError as error:
        print(f"TCP 443: {error}", file=sys.stderr)  # noqa: T201
    except (ValueError, EOFError, asyncio.LimitOverrunError) as error:
        print(f"no upgrade: {error}", file=sys.stderr)  # noqa: T201
    else:
        return 0
    return 1


if __name__ == "__main__":
    sys.exit(main())
