"""The table of faults, and how those outside the page break and mend."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.stop import by_page
from e2e.stop.camera import Control
from e2e.stop.fault import Fault, at_once
from e2e.stop.flooder import WAYS, flooded, press_stop, release_stop
from e2e.stop.hand import PAUSE_S, HandControl
from e2e.stop.relay import Relay
from e2e.stop.robots import KINDS, MECANUM, OTHERS
from e2e.stop.stage import STOPS_AT_EACH_TRIAL, random_phase

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.stop.fault import Scene

_BLOCKED_S: Final = 1.0
_A_CONNECTION: Final = 5
"""Trials over each connection: a peer is slow to trust a network that has vanished a few times."""
_FROZEN_S: Final = 0.06
"""The touch comes within this time of the server's end, before its silence stops the robot."""


@asynccontextmanager
async def _behind_a_relay(scene: Scene) -> AsyncIterator[None]:
    scene.prop = Relay()
    scene.on_socket = scene.prop.tap
    yield


async def _cut_network(scene: Scene) -> float:
    scene.prop.cut()
    return float(scene.prop.last_command_s)


async def _mend_network(scene: Scene) -> None:
    scene.prop.mend()
    if scene.trials % _A_CONNECTION == 0:
        await scene.come()


async def _restart_server(scene: Scene) -> None:
    await scene.leave()
    await scene.stage.again()
    await scene.come(anew=True)


async def _resume_server(scene: Scene) -> None:
    """Continue; what was sent before waits in the server's sockets, and nothing newer."""
    scene.operator.is_silent = True
    await asyncio.sleep(0.02)
    os.kill(scene.stage.server.pid, signal.SIGCONT)


async def _block_loop(scene: Scene) -> float:
    """Make the loop sleep, through a camera, which any plug-in may be; the threads continue."""
    return float(await scene.rig.block(_BLOCKED_S))


async def _fall_silent(scene: Scene) -> None:
    """Fall silent; the server has only what was sent before."""
    scene.operator.is_silent = True


async def _kill_driver(scene: Scene) -> float:
    pid = scene.stage.driver_pid
    await random_phase()
    since_s = time.monotonic()
    os.kill(pid, signal.SIGKILL)
    return since_s


async def _until_it_answers(scene: Scene) -> None:
    await scene.stage.answers()


async def _cut_link(scene: Scene) -> float:
    since_s = time.monotonic()
    await scene.stage.robot.cut()
    await scene.stage.server.until(
        lambda told: not told["robot"]["connected"], "the server knows of the loss", every_s=0.02
    )
    return since_s


async def _mend_link(scene: Scene) -> None:
    await scene.stage.robot.mend()
    await scene.stage.answers()


async def _touch_alone(scene: Scene) -> float:
    os.kill(scene.stage.server.pid, signal.SIGSTOP)
    await asyncio.sleep(_FROZEN_S * (scene.trials % 10) / 10)
    return float(scene.rig.touch())


async def _give_back(scene: Scene) -> None:
    os.kill(scene.stage.server.pid, signal.SIGCONT)
    scene.rig.let_go()
    await asyncio.sleep(PAUSE_S)


_LINKED: Final = tuple(kind for kind in OTHERS if kind.is_linked)
_STANDBY: Final = tuple(kind for kind in OTHERS if kind.has_standby)
_ALONE: Final = tuple(kind for kind in OTHERS if kind.time_out_ms is not None)
_KILL_SERVER: Final = at_once(lambda scene: os.kill(scene.stage.server.pid, signal.SIGKILL))
_FREEZE_SERVER: Final = at_once(lambda scene: os.kill(scene.stage.server.pid, signal.SIGSTOP))
_HAND: Final = Fault(
    "hand",
    "hand control aboard touched → stop frame",
    *(at_once(lambda scene: scene.rig.touch()), _give_back),
    rig=HandControl,
    goal_ms=70.0,
    at_once=4,
)
_FLOOD: Final = Fault(
    "stop-in-flood",
    "Stop pressed while a viewer offers 10,000 messages a second → stop frame",
    *(partial(press_stop, WAYS), release_stop),
    prop=flooded,
    settings=STOPS_AT_EACH_TRIAL,
    goal_ms=100.0,
    judged="p99",
    look_s=0.15,
)

_NETWORK: Final = Fault(
    "network-vanishes",
    "operator's network vanishes at full speed: last packet that arrived → stop frame",
    *(_cut_network, _mend_network),
    prop=_behind_a_relay,
    at_full_speed=True,
    resumes=True,
    minutes=2.3,
)

FAULTS: Final = (
    _NETWORK,
    replace(
        _NETWORK,
        key="network-vanishes: sideways",
        what="… a mecanum board at full diagonal speed: last packet that arrived → stop frame",
        kinds=(MECANUM,),
    ),
    Fault(
        "browser-frozen",
        "browser frozen (SIGSTOP) → stop frame",
        *(at_once(lambda scene: scene.prop.page.send(signal.SIGSTOP)), by_page.thaw),
        prop=by_page.driven,
        resumes=True,
        at_once=2,
    ),
    Fault(
        "browser-killed",
        "browser killed → stop frame",
        *(at_once(lambda scene: scene.prop.page.send(signal.SIGKILL)), by_page.follow),
        prop=partial(by_page.driven, queued=True),
        settings={"turns": {"grace_s": 0.0}},
        at_once=2,
        minutes=3.5,
    ),
    Fault(
        "another-tab",
        "another tab: first event in the page → zero",
        *(by_page.hide, by_page.show),
        prop=by_page.tab,
        goal_ms=120.0,
        n=50,
        resumes=True,
        minutes=1.3,
    ),
    Fault(
        "headset-off",
        "headset (emulated) taken off → zero",
        *(by_page.take_off, by_page.put_on),
        prop=by_page.headset,
        n=50,
        minutes=1.5,
    ),
    Fault(
        "camera-frozen",
        f"camera frozen: older than {by_page.AGE_MS:g} ms → stop frame",
        *(by_page.freeze_camera, by_page.thaw_camera),
        prop=by_page.driven,
        rig=Control,
        after_ms=by_page.AGE_MS,
        look_s=1.2,
        resumes=True,
        n=20,
    ),
    Fault(
        "loop-blocked",
        f"server's event loop blocked for {_BLOCKED_S:g} s → stop frame",
        *(_block_loop, _fall_silent),
        rig=Control,
        at_once=4,
        look_s=_BLOCKED_S - 0.2,
        held_on_s=0.5,
    ),
    Fault(
        "driver-killed",
        "driver's process killed → the board stops by itself",
        *(_kill_driver, _until_it_answers),
        goal_ms=250.0,
        by_itself=True,
        at_once=4,
    ),
    Fault(
        "serial-unplugged",
        "serial line unplugged → the board stops by itself",
        *(_cut_link, _mend_link),
        goal_ms=250.0,
        by_itself=True,
        held_on_s=0.5,
        at_once=4,
    ),
    Fault(
        "let-go",
        "operator lets go → message that stops",
        *(at_once(lambda scene: scene.operator.let_go()), _until_it_answers),
        goal_ms=25.0,
        judged="p99",
        kinds=KINDS,
        look_s=0.15,
        held_on_s=0.0,
    ),
    Fault(
        "server-killed",
        "server killed → message that stops",
        *(_KILL_SERVER, _restart_server),
        kinds=KINDS,
        held_on_s=0.0,
        minutes=11,
    ),
    Fault(
        "server-stopped",
        "server stopped (SIGSTOP) → message that stops",
        *(_FREEZE_SERVER, _resume_server),
        kinds=KINDS,
        held_on_s=0.3,
        minutes=2.2,
    ),
    Fault(
        "driver-killed: standby",
        "driver's process killed → its standby stops the robot",
        *(_kill_driver, _until_it_answers),
        kinds=_STANDBY,
        n=34,
    ),
    Fault(
        "driver-killed: alone",
        "driver's process killed → the robot stops, later than its own time-out",
        *(_kill_driver, _until_it_answers),
        goal_ms=100.0,
        kinds=_ALONE,
        n=10,
        by_itself=True,
        late=True,
    ),
    Fault(
        "link-cut",
        "link cut and mended: motions without a new deliberate command",
        *(_cut_link, _mend_link),
        goal_ms=None,
        kinds=_LINKED,
        n=10,
        held_on_s=0.5,
    ),
    _HAND,
    replace(
        _HAND,
        key="hand-alone",
        what="hand control aboard touched, server stopped (SIGSTOP) → stop frame",
        breaks=_touch_alone,
    ),
    _FLOOD,
    replace(
        _FLOOD,
        key="stop-in-flood: own",
        what="… by the flooder, over the very connection that they flood",
        breaks=partial(press_stop, ("flooder, channel",)),
        n=50,
    ),
)
