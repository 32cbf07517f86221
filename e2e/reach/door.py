"""The ssh tunnel's far end on a host of the small internet: `config/deploy/door.sh`, its programs.

The script writes into this machine's folders, which a mount namespace covers. Its sshd is hardened
as guides recommend. Two things differ from a real host: there is no systemd, so the programs are
started here as its units say, and no public authority, so Caddy signs its own certificates.
"""

from __future__ import annotations

import asyncio
import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.link import namespace
from e2e.measure.errors import NotRunError
from e2e.reach.internet import Host

if TYPE_CHECKING:
    from e2e.link.link import End
    from e2e.reach.internet import Internet

DOOR: Final = Host("door", "203.0.113.9", ipv6="2001:db8::9")
NAME: Final = "robot.example.org"
OTHER_NAME: Final = "robot-2.example.org"
_SCRIPT: Final = Path(__file__).parents[2] / "config" / "deploy" / "door.sh"
_READY_S: Final = 20.0
_MACHINE: Final = r"""
set -eu
work=$1 script=$2
shift 2
mkdir -p "$work/over" "$work/bin"
mount -t tmpfs tmpfs "$work/over"
for dir in etc usr/local/lib var/lib run; do
    over=$work/over/$dir
    mkdir -p "$over/up" "$over/work"
    mount -t overlay overlay -o "lowerdir=/$dir,upperdir=$over/up,workdir=$over/work" "/$dir"
done
cp "$work/hosts" /etc/hosts
printf '#!/bin/sh\n' >"$work/bin/systemctl"
chmod +x "$work/bin/systemctl"
PATH=$work/bin:$PATH
cat >/etc/ssh/sshd_config.d/10-hardened.conf <<'END'
AllowUsers admin
AllowGroups ssh-users
DisableForwarding yes
AllowTcpForwarding no
PermitListen none
END
for name; do sh "$script" "$name" >"$work/$name.line"; done
pages=$(cat /etc/caddy/Caddyfile)
printf '{\n\tlocal_certs\n\tskip_install_trust\n}\n%s\n' "$pages" >/etc/caddy/Caddyfile
echo 0 >/proc/sys/net/ipv4/ip_unprivileged_port_start
nft -f /etc/wax-door/relay.nft
as() { user=$1; shift; setsid setpriv --reuid "$user" --regid "$user" --init-groups "$@" & }
family() { for one in $(pgrep -P "$1"); do family "$one"; echo "$one"; done; }
kept=/var/lib/caddy/.local/share/caddy
while read -r word; do
    case $word in
    start)
        export HOME=/var/lib/caddy
        as caddy caddy run --config /etc/caddy/Caddyfile --adapter caddyfile
        caddy=$!
        setsid systemd-socket-activate --listen=127.0.0.1:20000 --accept --inetd \
            /usr/local/lib/wax-door-ssh &
        socket=$!
        for name; do
            until [ -f $kept/certificates/local/$name/$name.key ]; do sleep 0.02; done
        done
        cp $kept/pki/authorities/local/root.crt "$work/root.crt"
        /usr/local/lib/wax-door-certificate
        mkdir -p /run/sshd
        setsid /usr/sbin/sshd -D -e &
        sshd=$!
        as turnserver turnserver -c /etc/turnserver.conf --pidfile /tmp/none/pid
        turn=$!
        for port in 22 443 3478 20000; do
            until ss -ltn | grep -q ":$port "; do sleep 0.02; done
        done
        ;;
    kill)
        kill -9 $(family $socket) $(family $sshd) $caddy $socket $sshd $turn
        ;;
    esac
    echo "$word: done" >&3
done
"""


class Door:
    """A running door, and the lines that its script printed; it ends with the internet."""

    def __init__(self, process: asyncio.subprocess.Process, folder: Path, end: End) -> None:
        self._process = process
        self._folder = folder
        self._end = end

    def line(self, name: str = NAME) -> str:
        """Return the line that the script printed for this robot."""
        return (self._folder / f"{name}.line").read_text(encoding="ascii").strip()

    @property
    def root(self) -> str:
        """The path of the certificate that signs all of the door's certificates."""
        return str(self._folder / "root.crt")

    async def start(self) -> None:
        await self._say("start")

    async def kill(self) -> None:
        """End all of the door's programs at once, as if they had crashed."""
        await self._say("kill")

    async def unplug(self) -> None:
        """Disconnect the door from the network."""
        for device in ("outside", "outside6"):
            await self._ip(f"link set {device} down")

    async def plug(self) -> None:
        for line in (
            *("link set outside up", "route add 0.0.0.0/0 dev outside", "link set outside6 up"),
            f"address add {DOOR.ipv6}/128 nodad dev outside6",  # the kernel forgets IPv6 addresses
            "route add ::/0 dev outside6",
        ):
            await self._ip(line)

    async def _ip(self, line: str) -> None:
        process = await self._end.spawn([namespace.tool("ip", "iproute2"), *line.split()])
        assert await process.wait() == 0

    async def _say(self, word: str) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{word}\n".encode())
        said = await asyncio.wait_for(self._process.stdout.readline(), _READY_S)
        assert said == f"{word}: done\n".encode(), f"the door said {said!r}; see door.log"


def aliases(name: str) -> list[str]:
    """Return the spellings of a name: browsers write a dot after a STUN server's."""
    return [name, f"{name}."]


async def door(net: Internet, folder: Path, *names: str) -> Door:
    """Set up a door for robots of these names, start it, and tell every host the names."""
    if os.geteuid() != 0:
        raise NotRunError("sshd and coturn become users of their own, which takes root")
    for tool, package in (("sshd", "openssh-server"), ("caddy", "caddy"), ("turnserver", "coturn")):
        namespace.tool(tool, package)
    place = folder / "door"
    place.mkdir()
    hosts = place / "hosts"
    known = " ".join(alias for name in names for alias in aliases(name))
    known = f"{DOOR.address} {known}\n{DOOR.ipv6} {known}\n"
    hosts.write_text(f"127.0.0.1 localhost\n{known}", encoding="ascii")
    net.know(hosts)
    with (folder / "door.log").open("wb") as log:
        process = await net["door"].spawn(
            [
                "unshare",
                "--mount",
                "sh",
                "-c",
                f"exec 3>&1 >&2\n{_MACHINE}",
                "door",
                str(place),
                str(_SCRIPT),
                *names,
            ],
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=log,
        )
    made = Door(process, place, net["door"])
    await made.start()
    return made
