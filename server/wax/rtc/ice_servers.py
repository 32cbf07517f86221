"""The STUN and TURN servers that a browser is told of, with credentials that soon end.

A TURN password that every visitor sees would relay anybody's traffic for ever. coturn's "REST" way
(`use-auth-secret`; draft-uberti-behave-turn-rest-00) shares a secret with the TURN server, and
signs a user name that says when it ends.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
from typing import TYPE_CHECKING, Any, Final

from wax.named_file import told_secret

if TYPE_CHECKING:
    from wax.config.settings import NetworkSettings, RelaySettings

_LASTS_S: Final = 600
"""A relay that is in use goes on; a new one needs new credentials."""


class IceServers:
    """Makes the list for each viewer; raises `StartError` if the secret cannot be read."""

    def __init__(self, network: NetworkSettings, relay: RelaySettings) -> None:
        self._stun = [{"urls": url} for url in network.stun]
        self._wants_candidates = network.mode == "full-ice"
        self._relay = relay
        self._secret = _secret(relay)

    @property
    def relay_only(self) -> bool:
        """Whether browsers must use the relay."""
        return self._relay.only

    def page(self, viewer_id: str, wall_s: float) -> dict[str, Any]:
        """Return what the page wants to know before it connects; see `of`.

        The one port checks no candidates, so the page need not wait until it knows its own.
        """
        return {
            "iceServers": self.of(viewer_id, wall_s),
            "relayOnly": self.relay_only,
            "wantsCandidates": self._wants_candidates,
        }

    def of(self, viewer_id: str, wall_s: float) -> list[dict[str, Any]]:
        """Return the servers as browsers want them; `viewer_id` is for the TURN server's log.

        The credentials end ten minutes after `wall_s`, Unix time.
        """
        if not self._relay.urls:
            return list(self._stun)
        username = f"{int(wall_s) + _LASTS_S}:{viewer_id}"
        signed = hmac.digest(self._secret, username.encode(), hashlib.sha1)
        credential = base64.b64encode(signed).decode()
        urls = list(self._relay.urls)
        return [*self._stun, {"urls": urls, "username": username, "credential": credential}]


def _secret(relay: RelaySettings) -> bytes:
    if not relay.secret_file:
        return relay.secret.encode()
    holds = "; it holds the secret of the TURN server's static-auth-secret"
    return told_secret("relay.secret_file", relay.secret_file, holds)
