"""Makes CycloneDDS's configuration from ours (pure)."""

from __future__ import annotations

from ipaddress import ip_address
from typing import TYPE_CHECKING, Final
from xml.sax.saxutils import quoteattr

if TYPE_CHECKING:
    from collections.abc import Sequence

MAX_PARTICIPANTS: Final = 32
"""How many programs on one host can be discovered without multicast."""
_LOOPBACK_NAMES: Final = ("lo", "lo0", "localhost")


def cyclone_config(interface: str, peers: Sequence[str], inherited: str = "") -> str:
    """Return the argument of `dds_create_domain`: `inherited` (CYCLONEDDS_URI), overridden by ours.

    The loopback interface has no multicast, so there the peer's address is configured.
    """
    alone = _is_loopback(interface)
    wanted = [*peers, *(["127.0.0.1"] if alone and "127.0.0.1" not in peers else [])]
    chosen = f"<NetworkInterface {_which(interface)}/>" if interface else ""
    general = f"<Interfaces>{chosen}</Interfaces>" if chosen else ""
    if alone:
        general += "<AllowMulticast>false</AllowMulticast>"
    discovery = ""
    if wanted:
        among = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in wanted)
        discovery = (
            "<ParticipantIndex>auto</ParticipantIndex>"
            f"<MaxAutoParticipantIndex>{MAX_PARTICIPANTS - 1}</MaxAutoParticipantIndex>"
            f"<Peers>{among}</Peers>"
        )
    ours = (
        "<CycloneDDS><Domain>"
        f"<General>{general}</General><Discovery>{discovery}</Discovery>"
        "</Domain></CycloneDDS>"
    )
    return f"{inherited},{ours}" if inherited else ours


def _which(interface: str) -> str:
    try:
        ip_address(interface)
    except ValueError:
        name = "lo" if interface == "localhost" else interface
        return f"name={quoteattr(name)}"
    return f"address={quoteattr(interface)}"


def _is_loopback(interface: str) -> bool:
    try:
        return ip_address(interface).is_loopback
    except ValueError:
        return interface in _LOOPBACK_NAMES
