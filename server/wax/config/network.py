"""Names and addresses in the configuration."""

from __future__ import annotations

import ipaddress
from typing import Annotated
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field


def _network(text: str) -> str:
    try:
        ipaddress.ip_network(text, strict=False)
    except ValueError:
        raise ValueError(
            f'{text!r} is no address or network; one is "127.0.0.1", another "10.0.0.0/8"'
        ) from None
    return text


HostName = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?$",
        description='a host name or address without port, as "robot.example.org"',
        json_schema_extra={"plural": "addresses"},
    ),
]


def _page_url(text: str) -> str:
    urlsplit(text)  # raises ValueError for what is no IPv6 address
    return text


PageUrl = Annotated[
    str,
    Field(
        pattern=r"^(https?://([A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?|\[[0-9A-Fa-f:.]{2,45}\])"
        r"(:[0-9]{1,5})?(/[A-Za-z0-9._~-]+)*)?$",
        description='empty, or an address as "https://robot.example.org", without "/" at its end',
    ),
    AfterValidator(_page_url),
]

Network = Annotated[
    str,
    Field(
        description='an address or network, as "127.0.0.1" or "10.0.0.0/8"',
        json_schema_extra={"plural": "addresses"},
    ),
    AfterValidator(_network),
]
