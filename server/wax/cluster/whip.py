"""WHIP (RFC 9725): publish by one HTTP request with an offer, end it by another."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Final
from urllib.parse import urljoin

import aiohttp

from wax.as_written import as_written
from wax.cluster.bounded_answer import read_body
from wax.cluster.errors import RoomError, not_reached

if TYPE_CHECKING:
    from collections.abc import Callable

_OFFER_S: Final = 5.0
_END_S: Final = 1.0
_MAX_ANSWER_BYTES: Final = 65_536


class WhipSession:
    """One session at an endpoint; `token` returns the bearer token, empty for none."""

    def __init__(
        self, *, http: Callable[[], aiohttp.ClientSession], url: str, token: Callable[[], str]
    ) -> None:
        self._http = http
        self._url = url
        self._token = token
        self._resource: str | None = None

    async def offer(self, sdp: str) -> str:
        """Return the answer to an offer; raises `RoomError` with the server's own reason."""
        try:
            async with self._http().post(
                as_written(self._url),
                data=sdp.encode(),
                headers={"Content-Type": "application/sdp", **self._authorization()},
                timeout=aiohttp.ClientTimeout(total=_OFFER_S),
            ) as response:
                told = (await read_body(response, _MAX_ANSWER_BYTES)).decode(errors="replace")
        except (aiohttp.ClientError, TimeoutError) as error:
            raise await not_reached(self._url, error, _OFFER_S) from error
        if response.status != 201:
            raise RoomError(f"{self._url} refuses to publish ({response.status}): {told[:200]}")
        if (location := response.headers.get("Location")) is not None:
            self._resource = urljoin(self._url, location)
        return told

    async def end(self) -> None:
        """Delete the session at the server; safe to call twice, never raises."""
        resource, self._resource = self._resource, None
        if resource is None:
            return
        with suppress(aiohttp.ClientError, TimeoutError):
            async with self._http().delete(
                as_written(resource),
                headers=self._authorization(),
                timeout=aiohttp.ClientTimeout(total=_END_S),
            ):
                pass

    def _authorization(self) -> dict[str, str]:
        token = self._token()
        return {"Authorization": f"Bearer {token}"} if token else {}
