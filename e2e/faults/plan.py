"""The faults by name, and how often each is measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from e2e.faults.black_channel import black_channel
from e2e.faults.blind import camera_freezes, page_starves, video_starves
from e2e.faults.delay_step import delay_step
from e2e.faults.flood import stop_in_flood
from e2e.faults.hand_over import hand_over, one_turn
from e2e.faults.hands_off import hands_off
from e2e.faults.nuisance import nuisance
from e2e.faults.operator_gone import browser_frozen, browser_killed, network_vanishes
from e2e.faults.robot_gone import driver_killed, serial_unplugged
from e2e.faults.server_gone import loop_blocked, server_killed, server_stopped
from e2e.faults.steady_beat import steady_beat

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.faults.finding import Figure

    Measure = Callable[..., Awaitable[Figure | list[Figure]]]


@dataclass(frozen=True, slots=True)
class Fault:
    """`n` is how often the issue wants it; of what, `measure` says."""

    name: str
    n: int
    measure: Measure


async def _hand_over(n: int, **settings: Any) -> list[Figure]:
    return [*await hand_over(n, **settings), await one_turn(3, **settings)]


async def _blind(n: int, **settings: Any) -> list[Figure]:
    return [
        figure
        for measure in (camera_freezes, video_starves, page_starves)
        for figure in await measure(n, **settings)
    ]


FAULTS: Final = (
    Fault("network-vanishes", 200, network_vanishes),
    Fault("browser-frozen", 200, browser_frozen),
    Fault("browser-killed", 200, browser_killed),
    Fault("server-killed", 100, server_killed),
    Fault("server-stopped", 100, server_stopped),
    Fault("loop-blocked", 100, loop_blocked),
    Fault("driver-killed", 100, driver_killed),
    Fault("serial-unplugged", 100, serial_unplugged),
    Fault("delay-step", 50, delay_step),
    Fault("stop-in-flood", 200, stop_in_flood),
    Fault("hand-over", 1050, _hand_over),
    Fault("hands-off", 50, hands_off),
    Fault("blind", 25, _blind),
    Fault("nuisance", 600, nuisance),
    Fault("steady-beat", 3000, steady_beat),
    Fault("black-channel", 1000, black_channel),
)
"""The unit of n: trials; of ``hand-over`` turns, a few of which are over before they moved, of
``nuisance`` seconds, of ``steady-beat`` frames, of ``black-channel`` traces, of ``hands-off`` and
``blind`` trials of each kind.
"""

BY_NAME: Final = {fault.name: fault for fault in FAULTS}
