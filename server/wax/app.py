"""The composition root: builds every part, wires it, starts and stops it in order.

picture: source → capture → slot → rendition → lane → track → browser
sound:   source → capture → blocks → encoder → lane → track → browser
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
from wax.access.host_link import HostLinkSocket
from wax.access.secret_file import load_secret
from wax.baseline.streams import BaselineService, thesis_video
from wax.baseline.unit_hub import UnitHub
from wax.capture import find_sources
from wax.capture.audio_blocks import Blocks
from wax.capture.blanking import Blanking
from wax.capture.channel_faults import ChannelFaults
from wax.capture.source_thread import SourceThread
from wax.capture.timestamp_overlay import TimestampOverlay
from wax.cluster.cluster import Cluster, PublishedSources
from wax.cluster.room_directory import published, upload_left_bps
from wax.config.opening_hours import OpeningHours, zone_of
from wax.control.driving_view import DrivingView
from wax.control.loop import ControlLoop
from wax.control.turns import Turns
from wax.door.tunnel import Tunnel
from wax.edge.turnstile import Turnstile
from wax.encode.choice import choose
from wax.encode.video_encoder import IntraEncoder
from wax.errors import StartError
from wax.fanout.camera import Camera
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.hooks.hooks import Hooks
from wax.house.house import House
from wax.machine import cores, memory
from wax.machine.service_manager import ServiceManager
from wax.monitoring.listener import MetricsListener
from wax.monitoring.metrics import Metrics
from wax.monitoring.readiness import Readiness
from wax.records.opening import open_records
from wax.robot.find_driver import make_robot
from wax.robot.process.driver import ProcessDriver
from wax.rtc import private
from wax.rtc.ice_servers import IceServers
from wax.rtc.network import Network
from wax.session.changes import Fault, StateSeen, faults
from wax.session.event_maker import EventMaker
from wax.session.headroom import Headroom
from wax.session.host_decisions import HostDecisions
from wax.session.house_states import house_states
from wax.session.kept_state import KeptFile
from wax.session.page_messages import PageMessages
from wax.session.proof_runner import ProofRunner
from wax.session.record_keeper import RecordKeeper, refused
from wax.session.room import Room
from wax.session.status import Status
from wax.session.tape_keeper import TapeKeeper
from wax.session.viewers import Viewers
from wax.session.voices import Voices
from wax.speaker.find_speaker import make_speaker
from wax.speaker.speaker_thread import SpeakerThread
from wax.streams.live import LiveService
from wax.tape.tape import TapeFeed
from wax.tasks import TaskSupervisor
from wax.telemetry import Counters, CountRates
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

    from wax.capture.source import Picture, Sound
    from wax.clock import Clock
    from wax.config.server import ServerSettings
    from wax.config.settings import Settings
    from wax.config.sync import RoleSyncSettings
    from wax.protocol.events import Event
    from wax.sentence import Sentence
    from wax.streams.interface import Service

_LOG = structlog.get_logger(__name__)

_STOP_S: Final = 2.5
"""Once the robot has stopped, peers, sockets and threads together have this long to end."""


class App:
    """One robot, one server. Built outside the event loop, `run` once inside it.

    `config_path` is the settings' file, for the proof of the stop; `steps` returns the long steps
    of the event loop.
    """

    _audio: SoundHub | UnitHub

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
        self._counters = Counters()
        self._driver = make_robot(
            settings.robot,
            clock,
            settings.log,
            settings.local,
            claim=_claim(settings),
            controls=settings.controls,
        )
        self._decisions, self._kept = HostDecisions(), KeptFile(settings.server.state_dir)
        self._blanking = Blanking(lambda: self._decisions.is_blanked)
        is_thesis = settings.sync.policy == "thesis"
        self._encoders = [] if is_thesis else choose([settings.video, *settings.camera])
        self._cameras = [
            Camera(
                one,
                find_sources.make_camera(one, clock, self._driver),
                clock=clock,
                blank=self._blanking.picture,
                make_encoder=makers.make,
            )
            for one, makers in zip(settings.camera, self._encoders[1:], strict=True)
        ]
        self._cluster = Cluster(clock=clock, counters=self._counters)
        self._service = self._make_thesis_service() if is_thesis else self._make_live_service()
        self._view, self._blocks = DrivingView(), Blocks()
        self._captures = self._make_captures()
        self._channel_faults = ChannelFaults(_log_channel_fault, most=settings.audio.channels)
        self._ice = IceServers(settings.network, settings.relay)
        self._turns, turnstile = Turns(settings.turns), Turnstile(clock)
        self._headroom = Headroom(cores.usable(), clock, lambda: turnstile.charged_s)
        self._network = Network(settings.network, self._ice, clock, turnstile)
        self._tape = self._make_tape()
        self._viewers = Viewers(
            sync=settings.sync,
            turns=self._turns,
            has_camera="video" in self._captures,
            decisions=self._decisions,
        )
        self._control = ControlLoop(
            clock=clock,
            settings=settings,
            driver=self._driver,
            turns=self._turns,
            operators=self._viewers,
            view=self._view,
        )
        speaker = make_speaker(settings.voice, clock, self._driver)
        self._speaker = None if speaker is None else SpeakerThread(speaker, clock)
        self._voices = self._make_voices()
        self._records = open_records(settings.records, settings.server.state_dir, clock)
        self._access = Access(
            settings.access, self._records, clock, load_secret(settings.server.state_dir)
        )
        self._hooks = Hooks(settings.hook, clock, lambda: self._entrance.port)
        self._house = House(
            settings,
            clock,
            seen=self._house_states,
            act=lambda act: self._room.house_acts(act),  # noqa: PLW0108 - made below
        )
        self._tunnel = Tunnel(settings, clock, lambda: self._entrance.port)
        self._keeper = RecordKeeper(
            records=self._records,
            clock=clock,
            viewers=self._viewers,
            refused=lambda: refused(self._counters.snapshot() | self._control.counts()),
            event_maker=EventMaker(clock=clock, seen=self._seen, send=self._send),
        )
        self._tape_keeper = self._make_tape_keeper()
        listeners = (self._viewers, self._keeper, self._voices, self._tape_keeper)
        self._control.listen(*(one for one in listeners if one is not None))
        self._room = self._make_room()
        self._status = self._make_status(steps)
        self._proof_runner = ProofRunner(
            control=self._control,
            driver=self._driver,
            config_path=config_path,
            changed=self._viewers.changed,
        )
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
            self._service_manager.ready()
            on_ready(self._entrance.port)
            self._keeper.event_maker.ready(__version__)
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
        secret = self._access.new_host_link()
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
        self._control.stop()
        self._proof_runner.break_off()
        self._stopping.set()

    async def _start(self) -> None:
        # The ports first: if a server is already running, it must keep the robot and the camera.
        await self._entrance.open()
        await self._network.open()
        await self._host_link.open()
        if self._metrics is not None:
            await self._metrics.open()
        self._records.start()
        self._driver.open()
        self._room.resume()
        self._kept.start()
        self._video.start()
        self._audio.start()
        for capture in (*self._captures.values(), *self._cameras):
            capture.start()
        if self._speaker is not None:
            self._speaker.start()
        if self._tape is not None:
            self._tape.start()
        self._tunnel.start()
        self._supervisor.spawn("control loop", self._control.run())
        self._supervisor.spawn("memory", memory.run())
        self._supervisor.spawn("room", self._room.run())
        self._supervisor.spawn("headroom", self._headroom.run())
        self._supervisor.spawn("status", self._status.run())
        self._supervisor.spawn("public address", self._network.run())
        self._supervisor.spawn("records", self._keeper.run())
        if self._tape_keeper is not None:
            self._supervisor.spawn("tape", self._tape_keeper.run())
        self._supervisor.spawn("cluster", self._cluster.run())
        self._supervisor.spawn("hooks", self._hooks.run())
        self._supervisor.spawn("house", self._house.run())
        self._supervisor.spawn("service manager", self._service_manager.run())

    async def _shut_down(self) -> None:
        self._control.stop()
        self._proof_runner.break_off()
        self._service_manager.stopping()
        try:
            async with asyncio.timeout(_STOP_S):
                await self._supervisor.stop()
                await self._proof_runner.stop()
                self._keeper.close()
                # Concurrently, so that several slow devices share one wait.
                await asyncio.gather(
                    self._room.close(),
                    asyncio.to_thread(self._stop_threads),
                    self._hooks.close(),
                    self._house.close(),
                )
                await self._host_link.close()
                if self._metrics is not None:
                    await self._metrics.close()
                await self._entrance.close()
                if not await asyncio.to_thread(self._kept.close):
                    _LOG.warning("a Stop in force may end with the server", error="a slow disk")
        except TimeoutError:
            _LOG.warning("not everything ended in time; exiting anyway")
        finally:
            self._network.close()
            if self._died is not None and isinstance(self._driver, ProcessDriver):
                self._driver.abandon()  # a person aboard drives on
            else:
                self._driver.close()

    def _stop_threads(self) -> None:
        speakers = () if self._speaker is None else (self._speaker,)
        tape = () if self._tape is None else (self._tape,)
        captures = (*self._captures.values(), *self._cameras)
        parts = (*captures, self._video, self._records, self._tunnel, *speakers, *tape)
        for part in parts:
            part.request_stop()
        for part in parts:
            part.stop()

    def _make_thesis_service(self) -> Service:
        thesis = self._settings.thesis
        video = thesis_video(self._settings.video, thesis)
        self._video = VideoHub(settings=video, clock=self._clock, make_encoder=IntraEncoder)
        self._audio = UnitHub(mu_ms=thesis.audio_mu_ms)
        return BaselineService(
            clock=self._clock, settings=thesis, video=self._video, audio=self._audio
        )

    def _make_live_service(self) -> Service:
        settings, clock, make = self._settings, self._clock, self._encoders[0].make
        self._video = VideoHub(settings=settings.video, clock=clock, make_encoder=make)
        self._audio = SoundHub()
        service = LiveService(
            clock=clock,
            video_settings=settings.video,
            audio_settings=settings.audio,
            video=self._video,
            audio=self._audio,
            upload_bps=upload_left_bps(
                settings.network.upload_bps, settings.video.renditions, settings.publish
            ),
            cameras=self._cameras,
        )
        self._cluster.publish(
            settings.publish,
            [one.name for one in published(settings.video.renditions)],
            PublishedSources(
                service.codecs,
                self._video,
                self._audio if settings.access.strangers_hear else None,
            ),
        )
        return service

    def _make_room(self) -> Room:
        tape = self._tape_keeper
        return Room(
            settings=self._settings,
            clock=self._clock,
            counters=self._counters,
            service=self._service,
            turns=self._turns,
            viewers=self._viewers,
            control=self._control,
            page_messages=PageMessages(
                settings=self._settings,
                service=self._service,
                driver=self._driver,
                turns=self._turns,
                captures=self._captures,
                view=self._view,
                access=self._access,
                decisions=self._decisions,
                voices=self._voices,
                tape=lambda: None if tape is None else tape.status(),
                cameras=self._cameras,
                has_way_in=lambda: self._tunnel.problem is None,
                problems=lambda: [
                    *self._kept.problems(),
                    *self._tunnel.problems(),
                    *self._hooks.problems(),
                    *self._house.problems(),
                ],
            ),
            access=self._access,
            decisions=self._decisions,
            kept=self._kept,
            records=self._records,
            keeper=self._keeper,
            network=self._network,
            cluster=self._cluster,
            has_time=self._headroom.has_time,
            voices=self._voices,
            tape=tape,
        )

    def _make_status(self, steps: Callable[[], dict[str, dict[str, float]]]) -> Status:
        return Status(
            clock=self._clock,
            room=self._room,
            viewers=self._viewers,
            control=self._control,
            turns=self._turns,
            driver=self._driver,
            video=self._video,
            audio=self._audio,
            captures=self._captures,
            blocks=self._blocks,
            channel_faults=self._channel_faults,
            cluster=self._cluster,
            tape=None if self._tape is None else self._tape.recorder,
            counters=self._counters,
            rates=CountRates(),
            speaker=self._speaker,
            cameras=self._cameras,
            encoders=self._encoders,
            hooks=self._hooks.status,
            door=self._tunnel.status,
            steps=steps,
        )

    def _make_routes(self) -> Routes:
        settings, clock = self._settings, self._clock
        page = _page_data(self._service, settings.sync, has_voice=self._speaker is not None)
        return Routes(
            room=self._room,
            clock=clock,
            proving=self._proof_runner,
            ice=self._ice,
            status=lambda: (
                self._status()
                | {"connections": self._entrance.limits.status(), "mqtt": self._house.status()}
            ),
            branding=BrandedPage(settings.page, page, settings.server.public_url),
            guards=Guards(
                settings.server,
                clock,
                self._network.public_addresses,
                [one.livekit for one in settings.publish if one.livekit],
            ),
            access=self._access,
            offers_hz=settings.server.max_offers_per_address_hz,
            missing=Readiness(
                clock=clock,
                control=self._control,
                view=self._view,
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
            stops=self._keeper.stops,
            lateness=self._control.lateness,
            records=self._records,
        )
        return MetricsListener(self._settings.metrics, metrics.text)

    def _make_tape(self) -> TapeFeed | None:
        """Return the tape, None unless recording is enabled; raises `StateError`."""
        if not self._settings.recording.enabled or not isinstance(self._audio, SoundHub):
            return None
        return TapeFeed(
            self._settings,
            clock=self._clock,
            counters=self._counters,
            video=self._video if "video" in self._captures else None,
            audio=self._audio if "audio" in self._captures else None,
            cameras=self._cameras,
        )

    def _make_tape_keeper(self) -> TapeKeeper | None:
        if self._tape is None:
            return None
        return TapeKeeper(
            self._tape.recorder,
            settings=self._settings.recording,
            clock=self._clock,
            viewers=self._viewers,
            control=self._control,
            has_sound=self._tape.has_sound,
            has_cameras=self._tape.has_cameras,
            event_maker=self._keeper.event_maker,
        )

    def _send(self, event: Event) -> None:
        self._hooks.put(event)
        self._house.put(event)

    def _seen(self) -> StateSeen:
        """Return the state from whose changes events are made."""
        problems: dict[Fault, Sentence | None] = {
            ("camera" if name == "video" else "microphone", None): one.problem
            for name, one in self._captures.items()
        }
        problems |= {("camera", one.name): one.problem for one in self._cameras}
        state = self._control.robot_state
        return StateSeen(
            is_open=self._access.is_open,
            waiting=len(self._turns.queue),
            faults=faults(
                problems,
                state,
                self._settings.gauges,
                self._cluster.lost,
                self._tunnel.problem,
            ),
            battery_fraction=state.battery_fraction,
        )

    def _house_states(self) -> dict[str, str]:
        return house_states(
            self._room.snapshot(self._clock.now_s()),
            self._settings.gauges,
            is_open=self._access.is_open,
            names=self._settings.mqtt.names,
        )

    def _make_voices(self) -> Voices | None:
        if self._speaker is None:
            return None
        return Voices(
            speaker=self._speaker,
            clock=self._clock,
            counters=self._counters,
            decisions=self._decisions,
            role=lambda viewer: self._room.viewer_role(viewer),  # noqa: PLW0108 - made below
            changed=self._viewers.changed,
        )

    def _task_died(self, name: str) -> None:
        self._died = name
        self.stop()

    def _make_captures(self) -> dict[str, SourceThread[Picture] | SourceThread[Sound]]:
        video, audio = self._settings.video, self._settings.audio
        cameras = self._settings.camera
        find_sources.warn_of_shared_addresses(video.source, audio.source, cameras)
        taken = [one.source for one in cameras]
        sources = find_sources.make_sources(video, audio, self._clock, self._driver, taken)
        captures: dict[str, SourceThread[Picture] | SourceThread[Sound]] = {}
        if sources.video is not None:
            captures["video"] = self._view.camera = SourceThread(
                sources.video,
                self._picture_handler(),
                name="camera",
                clock=self._clock,
            )
        if sources.audio is not None:
            captures["audio"] = SourceThread(
                sources.audio,
                self._handle_sound,
                name="microphone",
                clock=self._clock,
            )
        return captures

    def _picture_handler(self) -> Callable[[Picture], None]:
        """Return the function that handles pictures in the camera's thread."""
        put: Callable[[Picture], None] = self._video.slot.put
        if self._settings.video.timestamp_overlay:
            put = TimestampOverlay(self._clock, put)

        def handle(picture: Picture) -> None:
            self._view.captured(picture.captured_s, picture.within_s)
            put(self._blanking.picture(picture))

        return handle

    def _handle_sound(self, sound: Sound) -> None:
        """Handle sound, in the microphone's thread."""
        heard = self._channel_faults.push(self._blanking.sound(sound))
        for block in self._blocks.push(heard):
            self._audio.push(block)


def _log_channel_fault(problem: str | None) -> None:
    if problem is None:
        _LOG.info("both channels of the microphone are back")
    else:
        _LOG.warning("one channel of the microphone has failed", problem=problem)


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
