"""The public keys of a proxy that signs tokens, from a file or by HTTPS, read anew when it changes.

Of an unknown key one try a minute is made, however many tokens name one. What has been read stays
while its source cannot be.
"""

from __future__ import annotations

import asyncio
import http.client
import urllib.request
from typing import TYPE_CHECKING, Final

import structlog

from wax.access.signed_tokens import MOST_BYTES, read_keys
from wax.authority import client_tls
from wax.daemon_call import daemon_call
from wax.errors import StartError, reason_of
from wax.folders import expanded
from wax.named_file import problem, read_bytes
from wax.second_look import explained
from wax.unreachable import Target

if TYPE_CHECKING:
    import jwt

    from wax.access.signed_tokens import Keys

_LOG = structlog.get_logger(__name__)

_KEY: Final = "access.proxy.keys"
_LIMIT_S: Final = 5.0
_WHOLE_S: Final = 20.0
LEAST_S: Final = 60.0
EVERY_S: Final = 3600.0


class PublishedKeys:
    """The keys at `source`; a file is read at once, and raises `StartError` if it cannot be."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._keys: Keys = {} if _is_address(source) else read(source)
        self._is_wanted = asyncio.Event()

    def get(self, name: str) -> jwt.PyJWK | None:
        """Return the key of this name; None if it is unknown, and then it is soon looked for."""
        key = self._keys.get(name)
        if key is None:
            self._is_wanted.set()
        return key

    async def run(self) -> None:
        """Read the keys every hour, and soon after one was missed, until cancelled."""
        while True:
            await self.refresh()
            await asyncio.sleep(LEAST_S)
            try:
                async with asyncio.timeout(EVERY_S - LEAST_S):
                    await self._is_wanted.wait()
            except TimeoutError:
                pass

    async def refresh(self) -> None:
        """Read them once; those before stay if that fails."""
        self._is_wanted.clear()
        try:
            async with asyncio.timeout(_WHOLE_S):
                self._keys = await daemon_call("sign-in keys", lambda: read(self._source))
        except (StartError, TimeoutError) as error:
            kept = len(self._keys)
            _LOG.warning("the keys of sign-ins cannot be read", error=reason_of(error), kept=kept)


def read(source: str) -> Keys:
    """Read the keys; blocks. Raises `StartError` with a sentence."""
    try:
        text = _fetched(source) if _is_address(source) else read_bytes(expanded(source), MOST_BYTES)
    except OSError as error:
        raise StartError(f"{_KEY}: {source} {problem(error)}") from error
    try:
        return read_keys(text)
    except (ValueError, RecursionError) as error:
        raise StartError(f"{_KEY}: {source} holds no JWKS: {error}") from error


def _fetched(url: str) -> bytes:
    target = Target.of(url, _LIMIT_S)
    assert target is not None, "the configuration takes no other address"
    tls = urllib.request.HTTPSHandler(context=client_tls("", _KEY))
    opener = urllib.request.build_opener(tls, urllib.request.ProxyHandler({}), _NoRedirects)
    try:
        with opener.open(url, timeout=_LIMIT_S) as answer:
            text: bytes = answer.read(MOST_BYTES + 1)
    except urllib.error.HTTPError as error:
        raise StartError(f"{_KEY}: {url} answers with {error.code}, not with keys") from error
    except (OSError, ValueError, http.client.HTTPException) as error:
        raise StartError(f"{_KEY}: {url}: {explained(target, error)}") from error
    if len(text) > MOST_BYTES:
        raise StartError(f"{_KEY}: {url} answers with more than {MOST_BYTES} bytes")
    return text


class _NoRedirects(urllib.request.HTTPRedirectHandler):
    """Follows no redirect: keys count only from where the configuration says."""

    def redirect_request(self, *_: object) -> None:
        return None


def _is_address(source: str) -> bool:
    return source.startswith("https://")
