"""`[network]`: how picture, sound and commands travel."""

from __future__ import annotations

from ipaddress import ip_address
from typing import Annotated, Literal

from pydantic import Field, field_validator

from wax.config.addresses import IpAddress, StunUrl
from wax.config.table import ConfigTable


class NetworkSettings(ConfigTable):
    """`[network]`: how picture, sound and commands reach the viewers."""

    mode: Literal["one-port", "full-ice"] = "one-port"
    udp_port: Annotated[int, Field(ge=0, le=65535)] = 8081
    public_addresses: Annotated[list[IpAddress], Field(max_length=4)] = []
    interfaces: Annotated[list[Annotated[str, Field(min_length=1)]], Field(max_length=16)] = []
    stun: Annotated[list[StunUrl], Field(max_length=4)] = []
    upload_bps: Annotated[int, Field(ge=0, le=10_000_000_000)] = 0

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
