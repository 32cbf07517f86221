"""The process that wires a small internet: namespaces, bridges, and the kernel's own NAT.

``python -m e2e.reach.wiring`` reads the hosts as one line of JSON, answers with one line, and ends
with its standard input. The internet lasts as long as another process holds the namespaces.
"""

from __future__ import annotations

import os
import sys
from ctypes import CDLL
from pathlib import Path
from typing import Final

from e2e.link import namespace
from e2e.link.statistics import HELLO, Hello
from e2e.measure.errors import NotRunError
from e2e.reach.internet import HOSTS, Host

_WORLD: Final = "world"
_OUTSIDE: Final = "outside"
"""A router's device towards the world or its provider, and a host's."""
_OUTSIDE_IPV6: Final = "outside6"
_GUARD: Final = f"""table ip6 home {{
    chain in {{
        type filter hook input priority filter
        iifname {_OUTSIDE_IPV6} meta l4proto {{ tcp, udp }} ct state new drop
    }}
}}"""
"""A home router's filter for IPv6, which needs no router of its own here."""


class Wiring:
    """The namespaces; raises `NotRunError` where none can be made."""

    def __init__(self) -> None:
        self.networks: dict[str, int] = {}
        """By the host's name, or by the address of a router's outer side."""
        self._cables = 0

    def wire(self, hosts: list[Host]) -> None:
        self._network(_WORLD, _bridge(_WORLD))
        for host in hosts:
            into = host.public or _WORLD
            if host.public is not None and host.public not in self.networks:
                up = host.carrier or _WORLD
                if host.carrier is not None:
                    self._router(Host("", host.public, host.carrier), into=_WORLD)
                self._router(host, into=up)
            self._network(host.name, [])
            gateway = None if host.public is None else _gateway(host.address)
            self._join(host.name, host.address, into, gateway)
            if host.ipv6 is not None:
                self._join(host.name, host.ipv6, _WORLD, None, _OUTSIDE_IPV6)
            if host.ipv6 is not None and host.public is not None:
                _enter(self.networks[host.name])
                namespace.run("nft", "nftables", ["-f", "-"], _GUARD)

    def _router(self, host: Host, *, into: str) -> None:
        """Make the router, or routers, between `host`'s household and the network behind `into`."""
        public, gateway = host.public or "", _gateway(host.address)
        self._network(public, [*_bridge(public), f"address add {gateway}/24 dev inside"])
        self._join(public, public, into, None if into == _WORLD else _gateway(public))
        _enter(self.networks[public])
        Path("/proc/sys/net/ipv4/ip_forward").write_text("1", encoding="ascii")
        namespace.run("nft", "nftables", ["-f", "-"], _rules(host, public))

    def _network(self, name: str, lines: list[str]) -> None:
        self.networks[name] = namespace.enter_new_network()
        namespace.ip(["link set lo up", *lines])

    def _join(
        self, name: str, address: str, into: str, gateway: str | None, device: str = _OUTSIDE
    ) -> None:
        """Connect a namespace to the bridge of another; all addresses are on the wire."""
        self._cables += 1
        end = f"/proc/{os.getpid()}/fd/{self.networks[into]}"
        port = f"port{self._cables}"
        kept, world = ("128 nodad", "::/0") if ":" in address else ("32", "0.0.0.0/0")
        _enter(self.networks[name])
        namespace.ip(
            [
                f"link add {device} type veth peer name {port} netns {end}",
                f"link set {device} addrgenmode none up",
                f"address add {address}/{24 if gateway else kept} dev {device}",
                f"route add {world} {f'via {gateway} ' if gateway else ''}dev {device}",
            ]
        )
        _enter(self.networks[into])
        namespace.ip([f"link set {port} addrgenmode none master {_bridge_of(into)} up"])


def _bridge_of(name: str) -> str:
    return _WORLD if name == _WORLD else "inside"


def _bridge(name: str) -> list[str]:
    device = _bridge_of(name)
    return [f"link add {device} type bridge", f"link set {device} addrgenmode none up"]


def _gateway(address: str) -> str:
    return f"{address.rpartition('.')[0]}.1"


def _rules(host: Host, public: str) -> str:
    """Return a router's rules: outgoing packets are translated, forwarded ports let in.

    A household also reaches its own forwarded port by the outer address (hairpinning, RFC 4787).
    Unsolicited packets are dropped before they become a connection, which would take the port of
    one that is about to be opened from inside.
    """
    forwards = "".join(
        f"ip daddr {public} {protocol} dport {port} dnat to {host.address}\n"
        for protocol, port in host.forwards
    )
    how = "masquerade fully-random" if host.symmetric else "masquerade"
    return f"""table ip home {{
        chain in {{
            type nat hook prerouting priority dstnat
            {forwards}
        }}
        chain out {{
            type nat hook postrouting priority srcnat
            oifname {_OUTSIDE} {how}
            iifname inside oifname inside masquerade
        }}
        chain down {{
            type filter hook input priority filter
            iifname {_OUTSIDE} drop
        }}
        chain through {{
            type filter hook forward priority filter
            {"" if host.udp else "meta l4proto udp drop"}
        }}
    }}"""


def _enter(network: int) -> None:
    # Python 3.12 and newer have os.setns.
    if CDLL(None).setns(network, 0) != 0:
        raise NotRunError("a network namespace of our own cannot be entered")


def main() -> int:
    hosts = HOSTS.validate_json(sys.stdin.readline())
    user = Path("/proc/self/ns/user").readlink()
    wiring = Wiring()
    try:
        wiring.wire(hosts)
        is_inside = Path("/proc/self/ns/user").readlink() != user
        hello = Hello(wiring.networks, is_inside)
    except NotRunError as error:
        hello = Hello(refused=str(error))
    print(HELLO.dump_json(hello).decode(), flush=True)
    sys.stdin.read()
    return 0


if __name__ == "__main__":
    sys.exit(main())
