"""One spelling for each host: that which browsers send, whatever the host of this server writes.

Names are in small letters, international ones as IDNA has them (UTS 46), addresses as short as they
can be.
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
    """Return a name or an address as browsers send it; raises `ValueError` for what is none.

    It can take milliseconds: it is for what the host writes, not for what strangers send.
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
    """Return an address with its host as browsers send it, without the port of its scheme.

    What reads as none is returned as it is; raises `ValueError` for a host that is none.
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
    """Return how a host is written: by browsers, as given, and in the letters of its language.

    Those are for programs that know nothing of IDNA.
    """
    if "xn--" not in host:
        return frozenset({host})
    import idna  # noqa: PLC0415 - its tables, which few need

    try:
        return frozenset({host, idna.decode(host)})
    except idna.IDNAError:
        return frozenset({host})
