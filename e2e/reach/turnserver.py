"""coturn as `config/deploy/turnserver.conf` sets it up, on a host of the small internet."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.link import namespace
from e2e.reach.stage import ROBOT, TURN

if TYPE_CHECKING:
    from e2e.reach.internet import Internet

PORT: Final = 3478
_CONFIG: Final = Path(__file__).parents[2] / "config" / "deploy" / "turnserver.conf"


SECRET: Final = "shared by robot and relay"


async def relay(net: Internet, folder: Path) -> None:
    """Start it on `TURN`, relaying to the robot alone; it ends with the internet."""
    program = namespace.tool("turnserver", "coturn")
    config = folder / "turnserver.conf"
    text = _CONFIG.read_text(encoding="utf-8")
    for key, value in (("static-auth-secret", SECRET), ("allowed-peer-ip", ROBOT.public)):
        text, found = re.subn(rf"^{key}=.*$", f"{key}={value}", text, flags=re.MULTILINE)
        assert found == 1, f"{_CONFIG} has {found} lines {key}"
    # Its addresses, and no files outside the test's folder.
    text += f"""
listening-ip={TURN.address}
relay-ip={TURN.address}
listening-port={PORT}
log-file={folder / "turnserver.log"}
simple-log
pidfile={folder / "turnserver.pid"}
userdb={folder / "turndb"}
"""
    config.write_text(text, encoding="utf-8")
    with (folder / "turnserver.out").open("wb") as log:
        await net["turn"].spawn(
            [program, "-c", str(config)], stdin=asyncio.subprocess.DEVNULL, stdout=log, stderr=log
        )
