"""`[network]`: how picture, sound and commands travel."""

from __future__ import annotations

from ipaddress import ip_address
from typing import Annotated, Literal

from pydantic import Field, field_validator

from wax.config.addresses import IpAddress, StunUrl
from wax.config.table import ConfigTable


class NetworkSettings(ConfigTable):
    """Picture, sound and commands travel by UDP, beside the page's HTTP."""

    mode: Literal["one-port", "full-ice"] = "one-port"
    """How viewers connect. "one-port" takes every viewer through udp_port: one port to forward on a
    router, to open in a firewall, or to map into a container. "full-ice" takes a new port for each
    viewer and makes the first step itself: for a network in which no port can be forwarded, with a
    server in stun or [relay]."""
    udp_port: Annotated[int, Field(ge=0, le=65535)] = 8081
    """The UDP port for everybody; a forwarded port must have the same number outside. 0 picks a
    free one."""
    public_addresses: Annotated[list[IpAddress], Field(max_length=4)] = []
    """The addresses at which the Internet knows this machine, if a router or a cloud forwards the
    port to it. Its own addresses are offered as well, for viewers in the same network."""
    interfaces: Annotated[list[Annotated[str, Field(min_length=1)]], Field(max_length=16)] = []
    """Network interfaces to use, by name ("wlan0") or address; all of them if the list is empty."""
    stun: Annotated[list[StunUrl], Field(max_length=4)] = []
    """STUN servers, which tell viewers and this machine their public addresses; this machine's is
    offered beside public_addresses, also when it changes. None by default, so that no outside host
    is ever contacted."""
    upload_bps: Annotated[int, Field(ge=0, le=10_000_000_000)] = 0
    """What all viewers together may be sent, in bits a second: what the provider promises as
    upload, less what the house needs of it. The operator's comes first; observers share the rest,
    with smaller pictures where it is short, and nobody is let in whose picture it would not carry;
    what the rooms of publish take comes off first. 0 is no limit. The policy "thesis" ignores
    it."""

    @field_validator("public_addresses")
    @classmethod
    def _are_addresses(cls, addresses: list[str]) -> list[str]:
        found = []
        for address in addresses:
            try:
                found.append(str(ip_address(address)))
            except ValueError:
                raise ValueError(
                    f"{address} is no address; write it as 203.0.113.7 or 2001:db8::7"
                ) from None
        return found
