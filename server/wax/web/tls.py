"""HTTPS: the certificate of new connections, renewed without a restart."""

from __future__ import annotations

import ipaddress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import structlog

from wax import state_dir
from wax.errors import StartError
from wax.web.certificate import Certificate, self_signed
from wax.web.host_names import own_addresses, own_names

if TYPE_CHECKING:
    import ssl

    from wax.clock import Clock
    from wax.config.server import ServerSettings

_LOG = structlog.get_logger(__name__)

_LOOK_S: Final = 2.0
"""The least time between two looks for changed files."""
_RENEW_S: Final = 60.0
"""The same for this machine's addresses and our own certificate's expiry."""


class Tls:
    """The server's side of TLS; raises `StartError` if its certificate cannot be used."""

    def __init__(self, settings: ServerSettings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock
        self._certificate = self._chosen()
        self._context = self._certificate.context()
        self.fingerprint = self._certificate.fingerprint()
        self._state = self._files()
        self._looked_s = self._renewed_s = clock.now_s()

    @property
    def is_self_signed(self) -> bool:
        return not self._settings.certificate

    def context(self) -> ssl.SSLContext:
        """Return the newest context; files that cannot be read leave the previous one in use."""
        now_s = self._clock.now_s()
        if now_s - self._looked_s >= _LOOK_S:
            self._looked_s = now_s
            self._renew(now_s)
        return self._context

    def _renew(self, now_s: float) -> None:
        try:
            if self.is_self_signed and now_s - self._renewed_s >= _RENEW_S:
                self._renewed_s = now_s
                self._certificate = self._chosen()
            state = self._files()
            if state == self._state:
                return
            self._state = state
            self._context = self._certificate.context()
            self.fingerprint = self._certificate.fingerprint()
        except (OSError, StartError) as error:
            _LOG.warning("the certificate stays as it was", problem=str(error))
            return
        _LOG.warning("new certificate", fingerprint=self.fingerprint)

    def _chosen(self) -> Certificate:
        if not self.is_self_signed:
            return Certificate(Path(self._settings.certificate), Path(self._settings.key))
        now = datetime.fromtimestamp(self._clock.wall_ms() / 1000, UTC)
        names = own_names() | {*self._settings.all_names}
        folder = state_dir.prepare(state_dir.find(self._settings.state_dir))
        return self_signed(folder, names | _lasting(own_addresses()), now)

    def _files(self) -> tuple[tuple[int, int, int], ...]:
        found = [path.stat() for path in (self._certificate.chain, self._certificate.key)]
        return tuple((one.st_mtime_ns, one.st_size, one.st_ino) for one in found)


def make_tls(settings: ServerSettings, clock: Clock) -> Tls | None:
    """Return the server's side of TLS if HTTPS is wanted; raises `StartError`."""
    return Tls(settings, clock) if settings.https or settings.certificate else None


def _lasting(addresses: set[str]) -> set[str]:
    """Leave out addresses that change every day (IPv6 privacy extensions, RFC 8981).

    Each of them would be another certificate that people must accept.
    """
    parsed = {text: ipaddress.ip_address(text) for text in addresses}
    return {text for text, one in parsed.items() if one.version == 4 or one.is_loopback}
