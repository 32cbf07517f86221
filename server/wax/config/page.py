"""`[page]`: the host's branding of the page."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from wax.config.addresses import Site
from wax.config.allowed import printable, said
from wax.config.table import ConfigTable

MAX_LINES = 6
"""The maximum of house rules, and of links: nobody reads more than six."""
MAX_SITES = 16
"""A header lists all of them with each embed."""


class LinkSettings(ConfigTable):
    """One of `[page] links`."""

    text: Annotated[str, printable(1, 40)]
    """What the link says."""
    url: Annotated[
        str,
        Field(
            pattern=r"^(https?://[^\s\x00-\x1f\x7f/?#]|mailto:[^\s\x00-\x1f\x7f@]+@)"
            r"[^\s\x00-\x1f\x7f]{1,400}$"
        ),
        said('an address as "https://example.org/us" or "mailto:us@example.org"'),
    ]
    """Where it leads."""


class PageSettings(ConfigTable):
    """What makes the page yours: whose robot this is, and what one may do with it. The same is
    shown beside a link to the page, where people send it to others.
    """

    name: Annotated[str, printable(1, 40)] = "WAX"
    """The robot's name, as the page's title."""
    sentence: Annotated[str, printable(0, 160)] = ""
    """What the robot is and what one may do, in one sentence. "" is one of the page's own, in the
    reader's language.

    Example: sentence = "A rover in our school's museum: look around, and say hello."
    """
    rules: Annotated[
        list[Annotated[str, printable(1, 120, "a sentence", plural="sentences")]],
        Field(max_length=MAX_LINES),
    ] = []
    """House rules, a short sentence each, shown before somebody first drives and in the page's
    menu.

    Example: rules = ["Drive slowly near people.", "Stay out of the kitchen."]
    """
    links: Annotated[list[LinkSettings], Field(max_length=MAX_LINES)] = []
    """Links in the page's menu: who you are, a way to reach you, what your law asks for.

    Example: links = [{ text = "About us", url = "https://example.org/us" }]
    """
    picture: str = ""
    """A picture for previews of links, as a file: PNG, JPEG or WebP of at most 1 MiB, 1200 pixels
    by 630 by preference. "" is none. Set [server] public_url where people elsewhere reach the
    page by it."""
    accent: Annotated[
        str,
        Field(pattern=r"^(#[0-9A-Fa-f]{6})?$"),
        said('empty, or a colour as "#0b6b4c"'),
    ] = ""
    """The colour of buttons and links. Where it would be hard to read it is made darker on the
    light theme and lighter on the dark one, so any colour will do. "" is the page's own green."""
    language: Literal["auto", "en", "de"] = "auto"
    """The page's language until a viewer chooses another; "auto" is that of their browser, if the
    page has it."""
    embed_on: Annotated[list[Site], Field(max_length=MAX_SITES)] = []
    """The sites on which pages may show this robot in a frame: ?view=embed, which has the picture,
    sound after a press, who drives, how many wait, and a link to this page. In the frame nobody
    drives or stops, and no cookie counts. All frames together get a quarter of the places at most.
    The host's panel shows the line of HTML to copy; a link to this page, pasted there, becomes the
    picture where the site knows oEmbed. Set [server] public_url, with https where the site has it.
    [] is nowhere. A frame with sandbox needs "allow-scripts allow-same-origin" in it; otherwise it
    only links here.

    Example: embed_on = ["https://museum.example"]
    """
