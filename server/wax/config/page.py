"""`[page]`: the host's branding of the page."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.addresses import Site
from wax.config.table import ConfigTable

MAX_LINES = 6
"""The maximum of house rules, and of links: nobody reads more than six."""
MAX_SITES = 16
"""A header lists all of them with each embed."""


class LinkSettings(ConfigTable):
    """One of `[page] links`."""

    text: Annotated[
        str,
        Field(
            pattern=r"^[^\x00-\x1f\x7f]{1,40}$",
            description="a text of 1 to 40 printable characters",
        ),
    ]
    url: Annotated[
        str,
        Field(
            pattern=r"^(https?://[^\s\x00-\x1f\x7f/?#]|mailto:[^\s\x00-\x1f\x7f@]+@)"
            r"[^\s\x00-\x1f\x7f]{1,400}$",
            description='an address as "https://example.org/us" or "mailto:us@example.org"',
        ),
    ]


class PageSettings(ConfigTable):
    """Every key has a default, with which the page is complete."""

    name: Annotated[
        str,
        Field(
            pattern=r"^[^\x00-\x1f\x7f]{1,40}$",
            description="a text of 1 to 40 printable characters",
        ),
    ] = "WAX"
    sentence: Annotated[
        str,
        Field(
            pattern=r"^[^\x00-\x1f\x7f]{0,160}$",
            description="a text of at most 160 printable characters",
        ),
    ] = ""
    rules: Annotated[
        list[
            Annotated[
                str,
                Field(
                    pattern=r"^[^\x00-\x1f\x7f]{1,120}$",
                    description="a sentence of 1 to 120 printable characters",
                    json_schema_extra={"plural": "sentences"},
                ),
            ]
        ],
        Field(max_length=MAX_LINES),
    ] = []
    links: Annotated[list[LinkSettings], Field(max_length=MAX_LINES)] = []
    picture: str = ""
    accent: Annotated[
        str,
        Field(
            pattern=r"^(#[0-9A-Fa-f]{6})?$",
            description='empty, or a colour as "#0b6b4c"',
        ),
    ] = ""
    language: Literal["auto", "en", "de"] = "auto"
    embed_on: Annotated[list[Site], Field(max_length=MAX_SITES)] = []
