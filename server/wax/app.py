"""The composition root: builds every part, wires it, starts and stops it in order.

picture and sound: `wax.pipelines`
command: browser → data channel → viewer → gate → control loop → driver
voice:   browser → receiver → floor → jitter buffer → decoder → speaker
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

import structlog

from wax import __version__, state_dir
from wax.access.access import Access
from wax.access.host_decisions import HostDecisions
from wax.access.host_link import HostLinkSocket
from wax.access.secret_file import load_secret
from wax.cluster.cluster import Cluster
from wax.config.opening_hours import OpeningHours, zone_of
from wax.config.proxy import doubts
from wax.congestion.late_loop import MeanDelay
from wax.control.loop import ControlLoop
from wax.control.turns import Turns
from wax.door.tunnel import Tunnel
from wax.edge.turnstile import Turnstile
from wax.encode.auto_size import prepare
from wax.errors import StartError
from wax.fanout.sound_hub import SoundHub
from wax.hooks.hooks import Hooks
from wax.house.house import House
from wax.machine import cores, memory, opencv
from wax.machine.service_manager import ServiceManager
from wax.monitoring.listener import MetricsListener
from wax.monitoring.metrics import Metrics
from wax.monitoring.readiness import Readiness
from wax.pipelines import Pipelines
from wax.records.opening import open_records
from wax.robot.find_driver import make_robot
from wax.robot.process.driver import ProcessDriver
from wax.rtc import private
from wax.rtc.ice_servers import IceServers
from wax.rtc.network import Network
from wax.session.changes import Fault, StateSeen, faults
from wax.session.event_maker import EventMaker
from wax.session.headroom import Headroom
from wax.session.house_states import house_states
from wax.session.kept_state import KeptFile
from wax.session.parts import Parts
from wax.session.proof_runner import ProofRunner
from wax.session.record_keeper import RecordKeeper, refused
from wax.session.room import Room
from wax.session.status import Status
from wax.session.tape_keeper import TapeKeeper
from wax.session.viewers import Viewers
from wax.session.voices import Voices
from wax.speaker.find_speaker import make_speaker
from wax.speaker.speaker_thread import SpeakerThread
from wax.tape.tape import TapeFeed
from wax.tasks import TaskSupervisor
from wax.telemetry import Counters
from wax.web import descriptors
from wax.web.branding import BrandedPage
from wax.web.entrance import Entrance
from wax.web.guards import Guards
from wax.web.opening_calendar import OpeningCalendar
from wax.web.page_urls import page_urls
from wax.web.routes import Routes
from wax.web.tls import make_tls

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.clock import Clock
    from wax.config.server import ServerSettings
    from wax.config.settings import Settings
    from wax.config.sync import RoleSyncSettings
    from wax.protocol.events import Event
    from wax.sentence import Sentence
    from wax.streams.interface import Service

_LOG = structlog.get_logger(__name__)

_RELIEVE_S: Final = 1.0
_STOP_S: Final = 2.5
"""Once the robot has stopped, peers, sockets and threads together have this long to end."""


class App:
    """One robot, one server. Built outside the event loop, `run` once inside it.

    `config_path` is the settings' file, for the proof of the stop; `steps` returns the long steps
    of the event loop.
    """

    def __init__(
        self,
        *,
        settings: Settings,
        clock: Clock,
        config_path: Path | None = None,
        steps: Callable[[], dict[str, dict[str, float]]] = dict,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._stopping = asyncio.Event()
        self._died: str | None = None
        self._supervisor = TaskSupervisor(self._task_died)
        self._service_manager = ServiceManager(os.environ)
        self._turnstile = turnstile = Turnstile(clock)
        self._ice = IceServers(settings.network, settings.relay)
        for what, advice in doubts(settings.access.proxy, settings.server):
            _LOG.warning(what, advice=advice)
        self._parts = parts = self._make_parts(turnstile)
        listeners = (parts.viewers, parts.keeper, parts.voices, parts.tape)
        parts.control.listen(*(one for one in listeners if one is not None))
        self._room = Room(parts)
        self._status = Status(parts, self._room, steps)
        self._proof_runner = ProofRunner(parts, config_path)
        routes = self._make_routes()
        self.tls = make_tls(settings.server, clock)
        self._host_link = HostLinkSocket(settings.server.state_dir, self.new_host_link)
        self._entrance = Entrance(
            routes.application(),
            _fitting(settings),
            clock,
            self.tls,
            turnstile=turnstile,
            who=routes.who,
            has_people_at=self.has_people_at,
            asked=parts.access.asked,
        )
        self._metrics = self._make_metrics()

    async def run(self, on_ready: Callable[[int], None]) -> None:
        """Serve until a signal, or until a task fails; the robot stops before anything else ends.

        `on_ready` gets the port once the page can be opened. Raises `StartError`.
        """
        private.install()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(NotImplementedError):  # Windows: Ctrl-C raises instead
                loop.add_signal_handler(number, self.stop)
        try:
            await self._start()
            memory.settle()
            opencv.keep_in_one_thread()
            self._service_manager.ready()
            on_ready(self._entrance.port)
            self._parts.keeper.event_maker.ready(__version__)
            await self._stopping.wait()
        finally:
            await self._shut_down()
        if self._died is not None:
            raise StartError(f"the server stopped: its task '{self._died}' failed; see the log")

    def new_host_link(self) -> list[str]:
        """Return links to the page; the first one opened makes its browser a host.

        The secret is a fragment (RFC 3986, 3.5), which browsers never send.
        """
        scheme = "https" if self.tls else "http"
        secret = self._parts.access.new_host_link()
        urls = page_urls(self._settings.server.host, self._entrance.port, scheme)
        public = self._settings.server.public_url
        return [f"{url}/#host={secret}" for url in (*urls, *([public] if public else []))]

    def has_people_at(self, address: str) -> bool:
        """Whether somebody at this address, in the limits' form, is in the room."""
        return self._room.has_people_at(address)

    @property
    def has_host_link(self) -> bool:
        """Whether `wax host-link` reaches this server."""
        return self._host_link.is_open

    def stop(self) -> None:
        """Stop the robot at once, then let `run` end."""
        self._parts.control.stop()
        self._proof_runner.break_off()
        self._stopping.set()

    async def _start(self) -> None:
        # The ports first: if a server is already running, it must keep the robot and the camera.
        await self._entrance.open()
        await self._parts.network.open()
        if self._settings.access.proxy.host_link:
            await self._host_link.open()
        if self._metrics is not None:
            await self._metrics.open()
        self._parts.records.start()
        self._parts.driver.open()
        self._room.resume()
        self._parts.kept.start()
        self._parts.pipelines.start()
        if self._parts.speaker is not None:
            self._parts.speaker.start()
        if self._tape is not None:
            self._tape.start()
        self._parts.tunnel.start()
        self._supervisor.spawn("control loop", self._parts.control.run())
        self._supervisor.spawn("memory", memory.run())
        self._supervisor.spawn("room", self._room.run())
        self._supervisor.spawn("headroom", self._parts.headroom.run())
        self._supervisor.spawn("late loop", self._relieve_late_loop())
        self._supervisor.spawn("status", self._status.run())
        if self._settings.access.proxy.token:
            self._supervisor.spawn("sign-in keys", self._parts.access.run())
        self._supervisor.spawn("public address", self._parts.network.run())
        self._supervisor.spawn("records", self._parts.keeper.run())
        if self._parts.tape is not None:
            self._supervisor.spawn("tape", self._parts.tape.run())
        self._supervisor.spawn("cluster", self._parts.cluster.run())
        self._supervisor.spawn("hooks", self._parts.hooks.run())
        self._supervisor.spawn("house", self._parts.house.run())
        self._supervisor.spawn("service manager", self._service_manager.run())

    async def _relieve_late_loop(self) -> None:
        lateness, service = self._parts.control.lateness, self._parts.pipelines.service
        ticks, datagrams = MeanDelay(), MeanDelay()
        while True:
            await asyncio.sleep(_RELIEVE_S)
            ticks_s = ticks.since_last(sum(lateness.counts), lateness.sum_s)
            service.relieve(max(ticks_s, datagrams.since_last(*self._turnstile.peers_waited)))

    async def _shut_down(self) -> None:
        self._parts.control.stop()
        self._proof_runner.break_off()
        self._service_manager.stopping()
        try:
            async with asyncio.timeout(_STOP_S):
                await self._supervisor.stop()
                await self._proof_runner.stop()
                self._parts.keeper.close()
                # Concurrently, so that several slow devices share one wait.
                await asyncio.gather(
                    self._room.close(),
                    asyncio.to_thread(self._stop_threads),
                    self._parts.hooks.close(),
                    self._parts.house.close(),
                )
                await self._host_link.close()
                if self._metrics is not None:
                    await self._metrics.close()
                await self._entrance.close()
                if not await asyncio.to_thread(self._parts.kept.close):
                    _LOG.warning("a Stop in force may end with the server", error="a slow disk")
        except TimeoutError:
            _LOG.warning("not everything ended in time; exiting anyway")
        finally:
            self._parts.network.close()
            if self._died is not None and isinstance(self._parts.driver, ProcessDriver):
                self._parts.driver.abandon()  # a person aboard drives on
            else:
                self._parts.driver.close()

    def _stop_threads(self) -> None:
        speakers = () if self._parts.speaker is None else (self._parts.speaker,)
        tape = () if self._tape is None else (self._tape,)
        others = (self._parts.records, self._parts.tunnel, *speakers, *tape)
        threads = (*self._parts.pipelines.threads, *others)
        for thread in threads:
            thread.request_stop()
        for thread in threads:
            thread.stop()

    def _make_parts(self, turnstile: Turnstile) -> Parts:
        clock, counters, given = self._clock, Counters(), self._settings
        driver = make_robot(
            given.robot,
            clock,
            given.log,
            given.local,
            claim=_claim(given),
            controls=given.controls,
        )
        prepared = prepare(given, driver)
        prepared.log()
        self._settings = settings = prepared.settings
        decisions, turns = HostDecisions(), Turns(settings.turns)
        pipelines = Pipelines(prepared, clock, driver, lambda: decisions.switches.is_blanked)
        cluster = Cluster(clock=clock, counters=counters)
        pipelines.publish(cluster)
        self._tape = self._make_tape(counters, pipelines)
        viewers = Viewers(
            sync=settings.sync,
            turns=turns,
            has_camera="video" in pipelines.captures,
            decisions=decisions,
        )
        control = ControlLoop(
            clock=clock,
            settings=settings,
            driver=driver,
            turns=turns,
            operators=viewers,
            view=pipelines.view,
        )
        records = open_records(settings.records, settings.server.state_dir, clock)
        hooks = Hooks(settings.hook, clock, lambda: self._entrance.port)
        house = House(
            settings,
            clock,
            seen=self._house_states,
            act=lambda act: self._room.house_acts(act),  # noqa: PLW0108 - made later
        )
        keeper = RecordKeeper(
            records=records,
            clock=clock,
            viewers=viewers,
            refused=lambda: refused(counters.snapshot() | control.counts()),
            event_maker=EventMaker(clock=clock, seen=self._seen, send=self._send),
        )
        sound_out = make_speaker(settings.voice, clock, driver)
        speaker = None if sound_out is None else SpeakerThread(sound_out, clock)
        return Parts(
            settings=settings,
            clock=clock,
            counters=counters,
            driver=driver,
            pipelines=pipelines,
            network=Network(settings.network, self._ice, clock, turnstile),
            cluster=cluster,
            turns=turns,
            viewers=viewers,
            control=control,
            access=Access(
                settings.access,
                records,
                clock,
                load_secret(settings.server.state_dir),
                decisions,
            ),
            decisions=decisions,
            kept=KeptFile(settings.server.state_dir),
            records=records,
            keeper=keeper,
            headroom=Headroom(cores.usable(), clock, lambda: turnstile.charged_s),
            tunnel=Tunnel(settings, clock, lambda: self._entrance.port),
            hooks=hooks,
            house=house,
            speaker=speaker,
            voices=None
            if speaker is None
            else Voices(
                speaker=speaker,
                clock=clock,
                counters=counters,
                decisions=decisions,
                viewers=viewers,
                turns=turns,
                control=control,
            ),
            tape=self._make_tape_keeper(viewers, control, keeper),
        )

    def _make_routes(self) -> Routes:
        settings, clock = self._settings, self._clock
        page = _page_data(
            self._parts.pipelines.service, settings.sync, has_voice=self._parts.speaker is not None
        )
        return Routes(
            self._parts,
            self._room,
            proving=self._proof_runner,
            ice=self._ice,
            status=lambda: (
                self._status()
                | {
                    "connections": self._entrance.limits.status(),
                    "mqtt": self._parts.house.status(),
                }
            ),
            branding=BrandedPage(
                settings.page,
                page,
                settings.server.public_url,
                settings.video.upright_size,
                is_for_known=settings.access.proxy.is_used,
            ),
            guards=Guards(
                settings.server,
                clock,
                self._parts.network.public_addresses,
                [one.livekit for one in settings.publish if one.livekit],
            ),
            missing=Readiness(
                clock=clock,
                control=self._parts.control,
                view=self._parts.pipelines.view,
                is_stopping=self._stopping.is_set,
            ),
            calendar=_calendar(settings, clock),
        )

    def _make_metrics(self) -> MetricsListener | None:
        if not self._settings.metrics.port:
            return None
        metrics = Metrics(
            status=self._status,
            refused=refused,
            stops=self._parts.keeper.stops,
            lateness=self._parts.control.lateness,
            records=self._parts.records,
        )
        return MetricsListener(self._settings.metrics, metrics.text)

    def _make_tape(self, counters: Counters, pipelines: Pipelines) -> TapeFeed | None:
        """Return the tape, None unless recording is enabled; raises `StateError`."""
        if not self._settings.recording.enabled or not isinstance(pipelines.audio, SoundHub):
            return None
        return TapeFeed(
            self._settings,
            clock=self._clock,
            counters=counters,
            video=pipelines.video if "video" in pipelines.captures else None,
            audio=pipelines.audio if "audio" in pipelines.captures else None,
            cameras=pipelines.cameras,
        )

    def _make_tape_keeper(
        self, viewers: Viewers, control: ControlLoop, keeper: RecordKeeper
    ) -> TapeKeeper | None:
        if self._tape is None:
            return None
        return TapeKeeper(
            self._tape.recorder,
            settings=self._settings.recording,
            clock=self._clock,
            viewers=viewers,
            control=control,
            has_sound=self._tape.has_sound,
            has_cameras=self._tape.has_cameras,
            event_maker=keeper.event_maker,
        )

    def _send(self, event: Event) -> None:
        self._parts.hooks.put(event)
        self._parts.house.put(event)

    def _seen(self) -> StateSeen:
        """Return the state from whose changes events are made."""
        problems: dict[Fault, Sentence | None] = {
            ("camera" if name == "video" else "microphone", None): one.problem
            for name, one in self._parts.pipelines.captures.items()
        }
        problems |= {("camera", one.name): one.problem for one in self._parts.pipelines.cameras}
        state = self._parts.control.robot_state
        return StateSeen(
            is_open=self._parts.access.is_open,
            waiting=len(self._parts.turns.queue),
            faults=faults(
                problems,
                state,
                self._settings.gauges,
                self._parts.cluster.lost,
                self._parts.tunnel.problem,
            ),
            battery_fraction=state.battery_fraction,
        )

    def _house_states(self) -> dict[str, str]:
        return house_states(
            self._room.snapshot(self._clock.now_s()),
            self._settings.gauges,
            is_open=self._parts.access.is_open,
            names=self._settings.mqtt.names,
        )

    def _task_died(self, name: str) -> None:
        self._died = name
        self.stop()


def _fitting(settings: Settings) -> ServerSettings:
    """Return `[server]` with its connections limited to those this process can have open."""
    descriptors.raise_limit()
    limit = descriptors.limit()
    most = descriptors.connections_that_fit(settings, limit)
    if most < settings.server.max_connections:
        _LOG.warning(
            "fewer connections fit than [server] max_connections: raise the limit of open files"
            " (LimitNOFILE=, ulimit -Hn)",
            connections=most,
            open_files=limit,
        )
    return settings.server.model_copy(update={"max_connections": most})


def _claim(settings: Settings) -> str:
    """Return the file by which a driver's process with a person aboard replaces another."""
    if not settings.local.is_on:
        return ""
    return str(state_dir.find(settings.server.state_dir) / "driver-claim")


def _calendar(settings: Settings, clock: Clock) -> OpeningCalendar | None:
    """Return the calendar of the opening hours; None if the robot is always open."""
    access = settings.access
    if not access.hours:
        return None
    hours = OpeningHours.of(access.hours, zone_of(access.time_zone))

    def now() -> datetime:
        return datetime.fromtimestamp(clock.wall_ms() / 1000, UTC)

    return OpeningCalendar(hours, settings.page, settings.server.public_url, now)


def _page_data(service: Service, sync: RoleSyncSettings, *, has_voice: bool) -> dict[str, str]:
    """Return what the page must know before it connects."""
    if service.acknowledged:
        return {"acknowledge": ""}
    players = {sync.operator.player, sync.observer.player}
    data = {"player": "browser"} if players == {"browser"} else {}
    data |= {"cameras": str(len(service.cameras))} if service.cameras else {}
    return data | ({"voice": ""} if has_voice else {})
