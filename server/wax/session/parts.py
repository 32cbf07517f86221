"""The running parts of a server, made by the composition root (`wax.app`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.access.access import Access
    from wax.access.host_decisions import HostDecisions
    from wax.clock import Clock
    from wax.cluster.cluster import Cluster
    from wax.config.settings import Settings
    from wax.control.loop import ControlLoop
    from wax.control.turns import Turns
    from wax.door.tunnel import Tunnel
    from wax.driver.interface import Driver
    from wax.hooks.hooks import Hooks
    from wax.house.house import House
    from wax.pipelines import Pipelines
    from wax.records.records import Records
    from wax.rtc.network import Network
    from wax.session.headroom import Headroom
    from wax.session.kept_state import KeptFile
    from wax.session.record_keeper import RecordKeeper
    from wax.session.tape_keeper import TapeKeeper
    from wax.session.viewers import Viewers
    from wax.session.voices import Voices
    from wax.speaker.speaker_thread import SpeakerThread
    from wax.telemetry import Counters


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What the room, its messages and its status are made from; None is what the robot lacks."""

    settings: Settings
    clock: Clock
    counters: Counters
    driver: Driver
    pipelines: Pipelines
    network: Network
    cluster: Cluster
    turns: Turns
    viewers: Viewers
    control: ControlLoop
    access: Access
    decisions: HostDecisions
    kept: KeptFile
    records: Records
    keeper: RecordKeeper
    headroom: Headroom
    tunnel: Tunnel
    hooks: Hooks
    house: House
    speaker: SpeakerThread | None = None
    voices: Voices | None = None
    tape: TapeKeeper | None = None
