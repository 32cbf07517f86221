"""The headers of every answer that restrict what browsers allow."""

from __future__ import annotations

import base64
import hashlib
import re
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

_STYLE: Final = re.compile(r"<style>(.*?)</style>", re.DOTALL)

_USED: Final = (
    "autoplay",
    "fullscreen",
    "gamepad",
    "microphone",
    "screen-wake-lock",
    "xr-spatial-tracking",
)
_UNUSED: Final = (
    "accelerometer",
    "camera",
    "display-capture",
    "encrypted-media",
    "geolocation",
    "gyroscope",
    "hid",
    "idle-detection",
    "local-fonts",
    "magnetometer",
    "midi",
    "payment",
    "publickey-credentials-get",
    "serial",
    "usb",
)

_ALWAYS: Final = {
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": ", ".join(
        [*(f"{name}=(self)" for name in _USED), *(f"{name}=()" for name in _UNUSED)]
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

UNDER_HTTPS: Final = {"Strict-Transport-Security": "max-age=31536000"}
"""Without subdomains: they may be other people's."""


def base_headers(room_urls: Iterable[str] = ()) -> Mapping[str, str]:
    """Return the headers of each answer; the page may also connect to `room_urls`.

    These are WebSocket URLs (``wss://…``), and allow HTTP at the same host as well.
    ``frame-ancestors`` is last: `Guards.frame_policy` appends to it.
    """
    origins = [f"{parts.scheme}://{parts.netloc}" for parts in map(urlsplit, room_urls)]
    both = [one for url in origins for one in (url, url.replace("ws", "http", 1))]
    connects = " ".join(["'self'", *dict.fromkeys(both)])
    policy = (
        f"default-src 'self'; connect-src {connects}; img-src 'self' data:; media-src 'self' blob:;"
        " object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
    )
    return {"Content-Security-Policy": policy, **_ALWAYS}


def policy_of_document(html: str) -> str:
    """Return the policy of a single file: it allows only its inline styles, by their hashes."""
    hashes = [
        base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
        for style in _STYLE.findall(html)
    ]
    styles = " ".join(f"'sha256-{one}'" for one in hashes) or "'none'"
    return f"default-src 'none'; style-src {styles}; base-uri 'none'; frame-ancestors 'none'"
