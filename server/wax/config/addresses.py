"""Types for host names and addresses in the configuration."""

from __future__ import annotations

import ipaddress
import re
from typing import Annotated, Final
from urllib.parse import urlsplit

from pydantic import AfterValidator, BeforeValidator, Field

from wax.config import host_spelling
from wax.config.allowed import said, shown


def _host(text: object) -> object:
    return host_spelling.of_host(text) if isinstance(text, str) else text


def _url(text: object) -> object:
    return host_spelling.of_url(text) if isinstance(text, str) else text


ONE_HOST: Final = BeforeValidator(_host)
"""Normalizes a host name to the spelling that browsers send."""
ONE_URL: Final = BeforeValidator(_url)
"""Normalizes the host of a URL in the same way."""


def _network(text: str) -> str:
    try:
        ipaddress.ip_network(text, strict=False)
    except ValueError:
        raise ValueError(
            f'{text!r} is no address or network; one is "127.0.0.1", another "10.0.0.0/8"'
        ) from None
    return text


_NAME: Final = r"[A-Za-z0-9_]([A-Za-z0-9._-]{0,251}[A-Za-z0-9_])?"
"""DNS allows no underscore in a host name, but many containers' names have one."""

HostName = Annotated[
    str,
    Field(pattern=rf"^{_NAME}$"),
    said('a host name or address without port, as "robot.example.org"', plural="addresses"),
    ONE_HOST,
]


def _site(text: str) -> str:
    """Return an origin that may show this page in a frame (CSP 3, 6.4.2); raises `ValueError`."""
    site = _SITE.match(text)
    if _USER.match(text):
        raise ValueError(f"{shown(text)} has a user's name; leave out all before the @")
    if "*" in text:
        raise ValueError(f"{text!r} has a wildcard; list each site by its name")
    if site is None:
        raise ValueError(f'{text!r} is no site; one is "https://museum.example"')
    if site["rest"]:
        raise ValueError(f"{text!r} has a path; write the whole site, {site['origin']!r}")
    if not 0 < int(site["port"] or 443) < 65536:
        raise ValueError(f"{text!r} has no valid port; leave it out, or correct it")
    if site["scheme"] == "http" and not _HERE.fullmatch(site["host"]):
        raise ValueError(f"{text!r} can be forged on its way; name a site with https, or localhost")
    return text


_SITE: Final = re.compile(
    r"(?P<origin>(?P<scheme>https?)://(?P<host>[a-z0-9](?:[a-z0-9.-]{0,251}[a-z0-9])?)"
    r"(?::(?P<port>[0-9]{1,5}))?)(?P<rest>[/?#].*)?\Z",
    re.ASCII | re.IGNORECASE | re.DOTALL,
)
_USER: Final = re.compile(r"[^/?#]*//[^/?#]*@")
_HERE: Final = re.compile(r"127\.0\.0\.1|(.+\.)?localhost", re.IGNORECASE)

Site = Annotated[
    str,
    said('a site as "https://museum.example"', plural="sites"),
    ONE_URL,
    AfterValidator(_site),
]


def _page_url(text: str) -> str:
    urlsplit(text)  # raises ValueError for what is no IPv6 address
    return text


PageUrl = Annotated[
    str,
    Field(
        pattern=rf"^(https?://({_NAME}|\[[0-9A-Fa-f:.]{{2,45}}\])"
        r"(:[0-9]{1,5})?(/[A-Za-z0-9._~-]+)*)?$"
    ),
    said('empty, or an address as "https://robot.example.org", without "/" at its end'),
    ONE_URL,
    AfterValidator(_page_url),
]

Network = Annotated[
    str,
    said('an address or network, as "127.0.0.1" or "10.0.0.0/8"', plural="addresses"),
    AfterValidator(_network),
]

StunUrl = Annotated[
    str,
    Field(pattern=r"^stun:\S+$"),
    said('an address as "stun:HOST:PORT"', plural="addresses"),
    ONE_URL,
]
TurnUrl = Annotated[
    str,
    Field(pattern=r"^turns?:\S+$"),
    said(
        'an address as "turn:HOST:PORT", "turns:HOST:PORT" or one of them with "?transport=tcp"',
        plural="addresses",
    ),
    ONE_URL,
]
IpAddress = Annotated[
    str,
    Field(pattern=r"^[0-9A-Fa-f.:]{2,45}$"),
    said("an IPv4 or IPv6 address", plural="addresses"),
]
