"""Checks whether only a proxy's word counts, where it says who people are (`[access.proxy]`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.access import published_keys
from wax.commands.doctor.verdict import Check, Verdict, ok, warning
from wax.config.proxy import doubts

if TYPE_CHECKING:
    from wax.config.settings import Settings

_KEYS_S: Final = 15.0


def checks(settings: Settings) -> list[Check]:
    """Return the checks, none unless a proxy says who people are."""
    proxy = settings.access.proxy
    return [Check("sign-in", lambda: _believed(settings), _KEYS_S)] if proxy.is_used else []


def _believed(settings: Settings) -> Verdict:
    server, proxy = settings.server, settings.access.proxy
    if proxy.token:
        n_keys = len(published_keys.read(proxy.keys))
        return ok(f"{proxy.keys} has {n_keys} keys, one of which must have signed who somebody is.")
    for what, advice in doubts(proxy, server):
        return warning(what, advice)
    return ok(f"Only {', '.join(server.trusted_proxies)} can say who somebody is.")
