"""The page's HTML with the host's own name, sentence and colour, and with tags for link previews.

The content security policy forbids inline styles, so the colour is a small style sheet. Its URL
and the picture's contain a hash of the content, so that browsers cache both.
"""

from __future__ import annotations

import hashlib
import re
from html import escape
from typing import TYPE_CHECKING, Final

from wax.errors import NotForUsError
from wax.sentence import Sentence
from wax.web import colours, oembed, preview_picture

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.config.page import PageSettings
    from wax.web.colours import Shades

STYLE_PATH: Final = "/page.css"
PICTURE_PATH: Final = "/preview"

_SENTENCES: Final = {
    "en": "Drive a real robot from your browser.",
    "de": "Steuere einen echten Roboter in deinem Browser.",
}
"""The description in link previews if the host gives none, by the page's language."""

_BLOCKED: Final = {
    "en": "Loading the robot’s picture… If it does not come, the site around this frame blocks it,"
    " or your browser is too old. To open the robot’s page, copy its address into a new tab:",
    "de": "Das Bild des Roboters wird geladen… Kommt es nicht, lässt die Website um diesen Rahmen"
    " es nicht zu, oder dein Browser ist zu alt. Um die Seite des Roboters zu öffnen, kopiere ihre"
    " Adresse in einen neuen Tab:",
}
"""What a frame with ``sandbox`` shows: without an origin it loads neither script nor style. It has
no link: what that opened would mostly inherit the sandbox."""

_TITLE: Final = re.compile(r"<title>[^<]*</title>")
_DESCRIPTION: Final = re.compile(r'<meta\s+name="description"\s+content="[^"]*"\s*/?>')
_LANGUAGE: Final = re.compile(r'<html lang="[^"]*"')
_LOADING: Final = re.compile(r'(<p class="loading">).*?(?=</p>)', re.DOTALL)
_PRELOAD: Final = re.compile(r'<link\s+rel="preload"[^>]*>')
"""A frame sends no cookies: what it preloaded with them would be loaded again."""
_NOT_IN_FRAMES: Final = ("voice", "cameras")


class BrandedPage:
    """The built page with the host's `[page]` settings; raises `ConfigError` for a bad picture.

    `data` is what the page must know before it connects, as attributes of its root element; `shape`
    has the proportions of the robot's picture. A page for people whom a proxy has signed in
    (`is_for_known`) has a script that shows again and again that they still are.
    """

    def __init__(
        self,
        settings: PageSettings,
        data: Mapping[str, str] | None = None,
        public_url: str = "",
        shape: oembed.Shape = (4, 3),
        *,
        is_for_known: bool = False,
    ) -> None:
        self._is_for_known = is_for_known
        self._settings = settings
        self._shape = shape
        self._public_url = public_url
        self.picture = preview_picture.read(settings.picture)
        self.style = _style(settings.accent)
        self.style_digest = hashlib.sha256(self.style.encode()).hexdigest()[:16]
        self._data = {"name": settings.name}
        if settings.sentence:
            self._data["sentence"] = settings.sentence
        if settings.language != "auto":
            self._data["language"] = settings.language
        self._data |= data or {}

    @property
    def embed_on(self) -> list[str]:
        """The sites that may show this robot in a frame."""
        return self._settings.embed_on

    def oembed(self, asked: Mapping[str, str], origin: str) -> dict[str, object]:
        """Return the oEmbed answer for a link to the page; raises `NotForUsError`."""
        if not self.embed_on:
            raise NotForUsError(Sentence("request.no_page"), 404)
        base = self._public_url or origin
        shown_at = self._picture_url(base)
        name = self._settings.name
        return oembed.answer(asked, base, name, self.picture, shown_at, shape=self._shape)

    def html(self, built: str, origin: str, *, is_embed: bool = False) -> str:
        """Return the built page as the host's own; `origin` is this server's in the browser.

        An embed is the page for a frame; its HTML tells it so. The host's texts are escaped: they
        can neither end an attribute nor begin an element.
        """
        settings = self._settings
        description = settings.sentence or _SENTENCES.get(settings.language, _SENTENCES["en"])
        base = self._public_url or origin
        text = built
        if settings.language != "auto":
            text = _LANGUAGE.sub(f'<html lang="{settings.language}"', text, count=1)
        told = self._data
        if is_embed:
            told = {name: told[name] for name in told if name not in _NOT_IN_FRAMES}
            told |= {"view": oembed.VIEW}
            text = _PRELOAD.sub("", text)
            blocked = _BLOCKED.get(settings.language, _BLOCKED["en"])
            text = _LOADING.sub(lambda found: f"{found[1]}{blocked} {escape(base)}/", text, count=1)
        data = "".join(f'data-{name}="{escape(value)}" ' for name, value in told.items())
        text = text.replace("<html ", f"<html {data}", 1)
        # A function, since `sub` would replace group references in the host's text.
        text = _TITLE.sub(lambda _: f"<title>{escape(settings.name)}</title>", text, count=1)
        text = _DESCRIPTION.sub(lambda _: _meta("name", "description", description), text, count=1)
        more = [*self._preview(description, base), *self._link()]
        if self._is_for_known and not is_embed:
            more.append('<script src="present.js" defer></script>')
        if self.embed_on:
            more += oembed.head(base, settings.name, self._shape)
        return text.replace("</head>", "".join(f"  {line}\n  " for line in more) + "</head>", 1)

    def _picture_url(self, base: str) -> str:
        return f"{base}{PICTURE_PATH}?{self.picture.digest if self.picture else ''}"

    def _link(self) -> list[str]:
        """Return the link to the colours; it follows the page's own style, and so overrides it."""
        if not self.style:
            return []
        return [f'<link rel="stylesheet" href="{STYLE_PATH[1:]}?{self.style_digest}" />']

    def _preview(self, description: str, base: str) -> list[str]:
        """Return the tags for link previews (Open Graph, and the cards derived from it)."""
        name = self._settings.name
        lines = [
            _meta("property", "og:type", "website"),
            _meta("property", "og:title", name),
            _meta("property", "og:description", description),
            _meta("property", "og:url", f"{base}/"),
            _meta("name", "twitter:card", "summary_large_image" if self.picture else "summary"),
        ]
        if self.picture is None:
            return lines
        return [
            *lines,
            _meta("property", "og:image", self._picture_url(base)),
            _meta("property", "og:image:type", self.picture.content_type),
            _meta("property", "og:image:width", str(self.picture.width)),
            _meta("property", "og:image:height", str(self.picture.height)),
            _meta("property", "og:image:alt", name),
        ]


def _meta(kind: str, name: str, content: str) -> str:
    return f'<meta {kind}="{name}" content="{escape(content)}" />'


def _style(accent: str) -> str:
    """Return the host's colours as a style sheet, empty if the page keeps its own."""
    if not accent:
        return ""
    night = _properties(colours.dark(accent))
    return (
        f":root{{{_properties(colours.light(accent))}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{night}}}}}\n"
    )


def _properties(shades: Shades) -> str:
    return (
        f"--accent:{shades.accent};--accent-press:{shades.press};"
        f"--on-accent:{shades.on_accent};--driving:{shades.driving};--calm:{shades.calm}"
    )
