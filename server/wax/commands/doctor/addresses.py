"""The addresses by which viewers reach this machine, and the NATs and firewalls in between."""

from __future__ import annotations

import ipaddress
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

import ifaddr

from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.rtc.stun_query import StunError, public_address

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.commands.doctor.network import ServedNetwork

    Address = ipaddress.IPv4Address | ipaddress.IPv6Address

CARRIER: Final = ipaddress.ip_network("100.64.0.0/10")
"""Addresses that providers share between customers (RFC 6598); some VPNs use them too."""
_VPN: Final = ("tailscale", "wg", "tun", "utun", "zt")
_UFW: Final = Path("/etc/ufw")
_FIREWALLD: Final = Path("/run/firewalld/firewalld.pid")
_NFTABLES: Final = Path("/etc/systemd/system/sysinit.target.wants/nftables.service")


def own_addresses() -> list[tuple[str, Address]]:
    """Return the interfaces' names and addresses, without loopback and link-local ones."""
    found = []
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            text = ip.ip if isinstance(ip.ip, str) else ip.ip[0]
            address = ipaddress.ip_address(text)
            if not (address.is_loopback or address.is_link_local):
                found.append((adapter.name, address))
    return found


def local_addresses(network: ServedNetwork, own: Sequence[tuple[str, Address]]) -> Verdict:
    """Say where the page is served, and whether that is a public address."""
    if network.is_local and not network.is_behind_proxy:
        return warning(
            "Only this machine can open the page.",
            "Start with --host 0.0.0.0, or set server.host, to let other devices in.",
        )
    if missing := set(network.interfaces) - {name for name, _ in own}:
        return bad(
            f"There is no interface {', '.join(sorted(missing))} with an address.",
            f"Set network.interfaces to some of {', '.join(sorted({name for name, _ in own}))}.",
        )
    if not own:
        return bad("This machine has no address in any network.", "Connect it to a network.")
    told = ", ".join(f"{address} ({name})" for name, address in own)
    public = [address for _, address in own if address.is_global]
    if public:
        return ok(f"This machine has a public address: {told}. Nothing needs to be forwarded.")
    carried = [name for name, address in own if address in CARRIER and not _is_vpn(name)]
    if network.door or carried:
        return _shared(network, told, carried)
    return ok(
        f"This machine has only private addresses: {told}. For viewers from elsewhere the router"
        f" must forward {network.ports} to it."
    )


def _shared(network: ServedNetwork, told: str, carried: Sequence[str]) -> Verdict:
    """Say that a door solves this, or that one is needed."""
    if not network.door:
        return warning(
            f"The provider shares its address with other customers: {told}.",
            "No port can be forwarded. Let people come through a door, a small public machine of"
            " yours (config/deploy/README.md), ask for an address of your own, or use IPv6.",
        )
    shared = ", which the provider shares with others" if carried else ""
    return ok(
        f"People elsewhere come through the door {network.door}, so no port need be open here:"
        f" {told}{shared}."
    )


def _is_vpn(name: str) -> bool:
    return name.lower().startswith(_VPN)


def world_address(network: ServedNetwork, own: Sequence[tuple[str, Address]]) -> Verdict:
    """Ask the STUN servers, if there are any, and compare the address that they see."""
    if not network.stun:
        if told := ", ".join(network.public_addresses):
            return ok(f"Viewers are told the public address {told}; no STUN server checks it.")
        return ok("No STUN server is given, so none was asked; `--stun HOST:PORT` asks one.")
    problem = ""
    for server in network.stun:
        try:
            return _seen(ipaddress.ip_address(public_address(server)), network, own)
        except StunError as error:
            problem = str(error)
    return bad(problem, "Check the server's name and that UDP may leave this network.")


def _seen(seen: Address, network: ServedNetwork, own: Sequence[tuple[str, Address]]) -> Verdict:
    """Compare the address that the world sees with our own and with the one that viewers get."""
    if any(seen == address for _, address in own):
        return ok(f"The world sees this machine as {seen}, its own address.")
    if network.udp_port is None:
        return ok(f"The world sees this machine as {seen}; each viewer's way is opened from here.")
    announced = [ipaddress.ip_address(one) for one in network.public_addresses]
    if announced and seen not in announced:
        return bad(
            f"The world sees this machine as {seen}, but viewers are told"
            f" {', '.join(map(str, announced))}.",
            f'Set network.public_addresses = ["{seen}"].',
        )
    forward = (
        f"Forward {network.ports} on the router. If its own page shows another address than"
        f" {seen}, or one from {CARRIER}, the provider shares it and forwarding cannot work."
    )
    if announced:
        return ok(f"The world sees this machine as {seen}, as viewers are told. {forward}")
    return warning(
        f"The world sees this machine as {seen}, the address of a router.",
        f'{forward} Set network.public_addresses = ["{seen}"].',
    )


def firewall(
    network: ServedNetwork,
    *,
    ufw: Path = _UFW,
    firewalld: Path = _FIREWALLD,
    nftables: Path = _NFTABLES,
) -> Verdict:
    """Look for a firewall on this machine, and at those of its rules that are readable."""
    ports = {f"{network.tcp_port}/tcp"}
    if network.udp_port is not None:
        ports.add(f"{network.udp_port}/udp")
    if _reads(ufw / "ufw.conf", r"(?m)^ENABLED=yes"):
        missing = sorted(port for port in ports if not _is_let_in(ufw, port))
        if not missing:
            return ok(f"The firewall ufw lets {network.ports} in.")
        commands = " && ".join(f"sudo ufw allow {port}" for port in missing)
        return warning("The firewall ufw is on and may shut viewers out.", f"Type `{commands}`.")
    if firewalld.exists():
        adds = " ".join(f"--add-port={port}" for port in sorted(ports))
        return warning(
            "firewalld is on and may shut viewers out.",
            f"Type `sudo firewall-cmd --permanent {adds} && sudo firewall-cmd --reload`.",
        )
    if nftables.exists():
        return warning(
            "nftables is on and may shut viewers out.",
            f"Make sure that /etc/nftables.conf lets {network.ports} in.",
        )
    return ok("No firewall of ufw, firewalld or nftables is on; the provider may have its own.")


def _is_let_in(ufw: Path, port: str) -> bool:
    """Whether a rule of ufw names the port; unreadable rules count as closed."""
    number, kind = port.split("/")
    # ufw notes each rule as "### tuple ### allow udp 8081 0.0.0.0/0 any 0.0.0.0/0 in".
    rule = rf"(?m)^### tuple ### allow ({kind}|any) {number} "
    return _reads(ufw / "user.rules", rule)


def _reads(path: Path, pattern: str) -> bool:
    try:
        return re.search(pattern, path.read_text(encoding="utf-8", errors="replace")) is not None
    except OSError:
        return False
