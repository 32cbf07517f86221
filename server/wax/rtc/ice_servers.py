"""The STUN and TURN servers that browsers use, with short-lived credentials.

A TURN password that every visitor sees would relay anybody's traffic for ever. coturn's REST API
(`use-auth-secret`; draft-uberti-behave-turn-rest-00) shares a secret with the TURN server, and
signs a user name that contains its expiry.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
from typing import TYPE_CHECKING, Any, Final

from wax.named_file import told_secret
from wax.protocol.http_bodies import IceAnswer, IceServer

if TYPE_CHECKING:
    from wax.config.network import NetworkSettings
    from wax.config.relay import RelaySettings

_LASTS_S: Final = 600
"""A relay in use outlives its credentials; a new one needs new ones."""


class IceServers:
    """Builds the list for each viewer; raises `StartError` if the secret cannot be read."""

    def __init__(self, network: NetworkSettings, relay: RelaySettings) -> None:
        self._stun = [{"urls": url} for url in network.stun]
        self._wants_candidates = network.mode == "full-ice"
        self._relay = relay
        self._secret = _secret(relay)

    @property
    def relay_only(self) -> bool:
        """Whether browsers must use the relay."""
        return self._relay.only

    def for_page(self, viewer_id: str, wall_s: float) -> IceAnswer:
        """Return what the page needs before it connects; see `for_viewer`.

        The one port checks no candidates, so the page need not wait to gather its own.
        """
        return IceAnswer(
            iceServers=[IceServer(**one) for one in self.for_viewer(viewer_id, wall_s)],
            relayOnly=self.relay_only,
            wantsCandidates=self._wants_candidates,
        )

    def for_viewer(self, viewer_id: str, wall_s: float) -> list[dict[str, Any]]:
        """Return the servers as browsers expect them; `viewer_id` is for the TURN server's log.

        The credentials expire ten minutes after `wall_s`, Unix time.
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
