"""Visitors and an admission, for tests that are about something else."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Final

from wax.access.access import Access
from wax.access.admission import Grant, Visitor
from wax.access.host_decisions import HostDecisions
from wax.config.access import AccessSettings

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.records.records import Records

TAB: Final = "tab-1111"
EVERYTHING: Final = Grant(hear=True, queue=True)


def visitor(identity: str, *, is_host: bool = False, address: str = "192.0.2.1") -> Visitor:
    """Return somebody who was not invited."""
    return Visitor(identity, address, "a sign-in" if is_host else "")


def make_access(
    records: Records,
    clock: Clock,
    settings: AccessSettings | None = None,
    secret: bytes | None = None,
    decisions: HostDecisions | None = None,
) -> Access:
    """Return an admission; `secret` makes it that of another, as after a restart."""
    return Access(
        settings or AccessSettings(),
        records,
        clock,
        secret or secrets.token_bytes(32),
        decisions or HostDecisions(),
    )
