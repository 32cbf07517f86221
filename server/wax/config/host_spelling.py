"""Normalizes host names and addresses to the spelling that browsers send.

Names are in lower case, international ones in IDNA (UTS 46), and IP addresses in their shortest
form.
"""

from __future__ import annotations

import ipaddress
import re
from functools import lru_cache
from typing import Final

_URL: Final = re.compile(
    r"(?P<scheme>[a-z][a-z0-9+.-]*:(?://)?)"
    r"(?:\[(?P<v6>[0-9a-f:.]+)\]|(?P<name>[^\s/?#:@\[\]\\]+))"
    r"(?P<port>:[0-9]+)?(?P<rest>[/?#].*)?",
    re.ASCII | re.IGNORECASE | re.DOTALL,
)
DEFAULT_PORTS: Final = {"http": ":80", "https": ":443"}


def of_host(text: str) -> str:
    """Return a name or an IP address as browsers send it; raises `ValueError` if it is neither.

    This can take milliseconds, so it is for the configuration, not for what strangers send.
    """
    try:
        return str(ipaddress.ip_address(text))
    except ValueError:
        if text.isascii():
            return text.lower()
    import idna  # noqa: PLC0415 - its tables, which few need

    try:
        return idna.encode(text, uts46=True).decode()
    except idna.IDNAError as error:
        raise ValueError(
            f"{text!r} is no host name ({error}); if browsers know it, write it as they send it,"
            ' which begins with "xn--"'
        ) from None


def of_url(text: str) -> str:
    """Return a URL with its host as browsers send it, without its scheme's default port.

    Text that is not a URL is returned unchanged; raises `ValueError` for an invalid host.
    """
    found = _URL.fullmatch(text)
    if found is None:
        return text
    v6, scheme = found["v6"], found["scheme"].lower()
    host = of_host(found["name"]) if v6 is None else f"[{of_host(v6)}]"
    port = found["port"] or ""
    if port == DEFAULT_PORTS.get(scheme.removesuffix("://")):
        port = ""
    return f"{scheme}{host}{port}{found['rest'] or ''}"


@lru_cache(maxsize=64)
def spellings(host: str) -> frozenset[str]:
    """Return a host's spellings: as browsers send it, and in the letters of its language.

    Programs without IDNA send the latter.
    """
    if "xn--" not in host:
        return frozenset({host})
    import idna  # noqa: PLC0415 - its tables, which few need

    try:
        return frozenset({host, idna.decode(host)})
    except idna.IDNAError:
        return frozenset({host})
