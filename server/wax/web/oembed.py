"""How other sites learn of the page's frame: from tags in its head, and by oEmbed 1.0.

`Guards.frame_policy` says which of them may show it.
"""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from wax.config.host_spelling import DEFAULT_PORTS, spellings
from wax.errors import NotForUsError
from wax.sentence import Sentence
from wax.web.host_names import host_and_port

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.web.preview_picture import PreviewPicture

OEMBED_PATH: Final = "/oembed"
VIEW: Final = "embed"
"""The value of ``?view=`` for a frame."""

Shape = tuple[int, int]
"""The width and height of the robot's picture, whose proportions a frame has."""

_FRAME: Final = f"/?view={VIEW}"
_WIDTH: Final = 640
_UNBOUNDED: Final = 100_000
_DIGITS: Final = 6
"""As many as `_UNBOUNDED` has; Python refuses to parse 5,000."""
_KEPT_S: Final = 3600
_NO_PAGE: Final = Sentence("request.no_page")


def head(base: str, name: str, shape: Shape) -> list[str]:
    """Return the tags about the frame for the head of the page at `base`."""
    about = f"{base}{OEMBED_PATH}?url={quote(f'{base}/', safe='')}&format=json"
    video = {
        "og:video": f"{base}{_FRAME}",
        "og:video:type": "text/html",
        "og:video:width": str(_WIDTH),
        "og:video:height": str(_height(_WIDTH, shape)),
    }
    return [
        f'<link rel="alternate" type="application/json+oembed" href="{escape(about)}"'
        f' title="{escape(name)}" />',
        *(f'<meta property="{key}" content="{escape(value)}" />' for key, value in video.items()),
    ]


def answer(
    asked: Mapping[str, str],
    base: str,
    name: str,
    picture: PreviewPicture | None,
    shown_at: str,
    *,
    shape: Shape,
) -> dict[str, object]:
    """Return the answer for a link to the page at `base`; `shown_at` is its picture's URL.

    Raises `NotForUsError` for any other page, and for XML. Nothing of the link is echoed, since it
    may contain a secret.
    """
    url = asked.get("url", "").partition("#")[0].partition("?")[0]
    if not _is_same_page(url, base):
        raise NotForUsError(_NO_PAGE, 404)
    if asked.get("format", "json") != "json":
        raise NotForUsError(_NO_PAGE, 501)
    wide, high = _bound(asked.get("maxwidth")), _bound(asked.get("maxheight"))
    width = min(_WIDTH, wide, max(1, high * shape[0] // shape[1]))
    height = _height(width, shape)
    told: dict[str, object] = {
        "version": "1.0",
        "type": "video",
        "title": name,
        "provider_name": name,
        "provider_url": f"{base}/",
        "cache_age": _KEPT_S,
        "html": f'<iframe src="{escape(base + _FRAME)}" title="{escape(name)}" width="{width}"'
        f' height="{height}" loading="lazy" allow="autoplay" style="border:0"></iframe>',
        "width": width,
        "height": height,
    }
    if picture is not None and picture.width <= wide and picture.height <= high:
        told["thumbnail_url"] = shown_at
        told["thumbnail_width"], told["thumbnail_height"] = picture.width, picture.height
    return told


def _is_same_page(url: str, base: str) -> bool:
    """Whether a URL is the page's, by http or https, however it is written."""
    try:
        host, *where = _parts(url)
    except ValueError:
        return False
    own_host, *own = _parts(base)
    return where == own and host in spellings(own_host)


def _parts(url: str) -> tuple[str, str, str]:
    """Return host, port unless it is the scheme's default, and path; raises `ValueError`."""
    scheme, _, rest = url.partition("://")
    authority, _, path = rest.partition("/")
    host, port = host_and_port(authority)
    if (usual := DEFAULT_PORTS.get(scheme.lower())) is None:
        raise ValueError("not a page's scheme")
    return host, port.removesuffix(usual), path.removesuffix("/")


def _height(width: int, shape: Shape) -> int:
    """Return the height for this width."""
    return max(1, width * shape[1] // shape[0])


def _bound(text: str | None) -> int:
    """Return the requested maximum; anything but a number is no bound."""
    if text is None or not (text.isascii() and text.isdigit()):
        return _UNBOUNDED
    digits = text.lstrip("0")
    return _UNBOUNDED if len(digits) > _DIGITS else max(1, int(digits or "0"))
