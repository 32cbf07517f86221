"""The DDS domain, shared by all links of this process: CycloneDDS allows one per number."""

from __future__ import annotations

import os
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from cyclonedds.core import DDSException
from cyclonedds.domain import Domain, DomainParticipant

from wax.errors import DriverError
from wax.robot.ros2.cyclone_config import cyclone_config
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.robot.ros2.settings import Ros2Settings

_LOCK: Final = threading.Lock()
_DOMAINS: Final[dict[int, _Shared]] = {}


class _Shared:
    def __init__(self, number: int, config: str) -> None:
        self.config = config
        self.users = 0
        self.domain = Domain(number, config)


@contextmanager
def participant(settings: Ros2Settings) -> Iterator[DomainParticipant]:
    """Make a participant in the configured domain; raises `DriverError`."""
    number = settings.domain
    config = cyclone_config(
        settings.interface, settings.peers, os.environ.get("CYCLONEDDS_URI", "")
    )
    with _LOCK, told(settings):
        shared = _DOMAINS.get(number)
        if shared is None:
            shared = _DOMAINS[number] = _Shared(number, config)
        elif shared.config != config:
            raise DriverError(Sentence("ros2.one_interface", {"domain": number}))
        shared.users += 1
    try:
        with told(settings):
            yield DomainParticipant(number)
    finally:
        with _LOCK:
            shared.users -= 1
            if shared.users == 0:
                del _DOMAINS[number]  # which ends it


@contextmanager
def told(settings: Ros2Settings) -> Iterator[None]:
    """Convert what CycloneDDS raises to a `DriverError` that says what to check."""
    try:
        yield
    except DDSException as error:
        where = settings.interface or "auto"
        why = str(error.msg or error)
        raise DriverError(
            Sentence("ros2.no_dds", {"domain": settings.domain, "interface": where, "why": why})
        ) from error
