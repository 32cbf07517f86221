"""coturn as `config/deploy/turnserver.conf` sets it up, on a host of the small internet."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.link import namespace

if TYPE_CHECKING:
    from e2e.reach.hosts import Host
    from e2e.reach.internet import Internet

PORT: Final = 3478
_CONFIG: Final = Path(__file__).parents[2] / "config" / "deploy" / "turnserver.conf"


class TurnServer:
    """On `host`, with a `secret`; it relays to one host alone."""

    def __init__(self, host: Host, secret: str, *, to: Host) -> None:
        self._host = host
        self._secret = secret
        self._to = to
        self._program = namespace.tool("turnserver", "coturn")

    async def start(self, net: Internet, folder: Path) -> None:
        """Start it; it ends with the internet."""
        config = folder / "turnserver.conf"
        text = _CONFIG.read_text(encoding="utf-8")
        for key, value in (
            ("static-auth-secret", self._secret),
            ("allowed-peer-ip", self._to.public or self._to.address),
        ):
            text, found = re.subn(rf"^{key}=.*$", f"{key}={value}", text, flags=re.MULTILINE)
            assert found == 1, f"{_CONFIG} has {found} lines {key}"
        # Where it runs, and no files outside the test's folder.
        text += f"""
listening-ip={self._host.address}
relay-ip={self._host.address}
listening-port={PORT}
log-file={folder / "turnserver.log"}
simple-log
pidfile={folder / "turnserver.pid"}
userdb={folder / "turndb"}
"""
        config.write_text(text, encoding="utf-8")
        with (folder / "turnserver.out").open("wb") as log:
            await net["turn"].spawn(
                [self._program, "-c", str(config)],
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )
