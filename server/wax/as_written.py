"""Requests a URL byte for byte as it is written: re-encoding would break a signed one. Pure."""

from __future__ import annotations

import re
from typing import Final

from aiohttp import InvalidURL
from yarl import URL

_ORIGIN: Final = re.compile(r"[^/?#]*//[^/?#]*")


def as_written(url: str) -> URL:
    """Return the URL with path and query untouched, where yarl would turn `%2F` into `/`.

    Raises `aiohttp.InvalidURL`.
    """
    try:
        made = URL(url)
        rest = _ORIGIN.sub("", url, count=1)
        return URL(f"{made.scheme}://{made.raw_authority}{rest}", encoded=True)
    except ValueError as error:
        raise InvalidURL(url) from error
