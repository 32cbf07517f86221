"""The HTTP routes of a server whose other parts are fakes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from tests.turned_clock import TurnedClock
from tests.visitors import make_access

from wax.config.network import NetworkSettings
from wax.config.page import PageSettings
from wax.config.relay import RelaySettings
from wax.config.server import ServerSettings
from wax.config.settings import Settings
from wax.errors import ForbiddenError
from wax.protocol.http_bodies import ProofProgress
from wax.records.records import Records
from wax.rtc.ice_servers import IceServers
from wax.web.branding import BrandedPage
from wax.web.guards import Guards
from wax.web.routes import Routes

if TYPE_CHECKING:
    from wax.access.access import Access


class Lent:
    """A proof runner that never runs."""

    def __init__(self) -> None:
        self.started = 0
        self.page: str | None = None

    async def start(self) -> None:
        self.started += 1

    def progress(self) -> ProofProgress:
        return ProofProgress(state="never", line=None, record=None)

    def record(self) -> str:
        if self.page is None:
            raise ForbiddenError("no record")
        return self.page


def make_routes(
    room: Any,
    *,
    clock: TurnedClock | None = None,
    access: Access | None = None,
    offers_hz: float = 2.0,
    **others: Any,
) -> Routes:
    """Make the routes; `others` replace their remaining arguments."""
    clock = clock or TurnedClock()
    settings = Settings(server=ServerSettings(max_offers_per_address_hz=offers_hz))
    parts: Any = SimpleNamespace(
        clock=clock, settings=settings, access=access or make_access(Records(clock), clock)
    )
    known: dict[str, Any] = {
        "ice": IceServers(NetworkSettings(), RelaySettings()),
        "status": dict,
        "proving": Lent(),
        "branding": BrandedPage(PageSettings()),
        "guards": Guards(ServerSettings(), clock),
        "missing": dict,
    }
    return Routes(parts, room, **known | others)
