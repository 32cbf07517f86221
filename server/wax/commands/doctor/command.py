"""`wax doctor`: runs every check, prints each verdict as it comes, and exits with the worst."""

from __future__ import annotations

import datetime
import json
from functools import cache, partial
from typing import TYPE_CHECKING, Final

from wax import state_dir
from wax.clock import SystemClock
from wax.commands.doctor import (
    addresses,
    certificate,
    devices,
    door,
    machine,
    ports,
    reach,
    sign_in,
)
from wax.commands.doctor.files import files
from wax.commands.doctor.network import network_of
from wax.commands.doctor.verdict import Check, Verdict, bad, examine, ok
from wax.config import settings as config
from wax.encode.auto_size import prepare
from wax.encode.trials import LIMIT_S
from wax.errors import ConfigError, WaxError
from wax.hooks.signature import read_secret
from wax.house.discovery import published_topics, topic_of
from wax.house.house import broker_link
from wax.robot.find_driver import make_driver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from wax.config.hook import HookSettings
    from wax.config.settings import Settings
    from wax.driver.interface import Driver
    from wax.encode.auto_size import Prepared

_DEVICE_S: Final = 15.0
"""OpenCV gives up on a camera after 10 s."""
_BROKER_S: Final = 28.0
"""Enough to connect, log in and probe the commands, or to find out why that fails."""
_ENCODERS_S: Final = 2 * LIMIT_S + 4
"""Enough for trials of encoders that hang, and for a second of encoding."""


def doctor(
    read: Callable[[], Settings],
    path: Path | None,
    *,
    tell: Callable[[str], None],
    stun: str | None = None,
    reach_url: str | None = None,
    as_json: bool = False,
) -> int:
    """Check this machine, or the path to `reach_url`; return 1 if anything is bad, else 0.

    `read` returns the settings or raises `ConfigError`; `path` is their file. No outside host is
    contacted, except for `stun` or a configured STUN server, a configured broker, and `reach_url`.
    """
    if reach_url is not None:
        checks: Iterable[Check] = _from_outside(reach.checked_url(reach_url))
    else:
        checks = _here(read, path, stun)
    found: list[tuple[str, Verdict]] = []
    for check in checks:
        verdict = examine(check)
        found.append((check.name, verdict))
        if not as_json:
            tell(_line(check.name, verdict))
    if as_json:
        tell(json.dumps([_tree(name, verdict) for name, verdict in found], indent=1))
    return 1 if any(verdict.level == "bad" for _, verdict in found) else 0


def _from_outside(url: str) -> list[Check]:
    return [
        Check("page", lambda: reach.page(url), reach.LIMIT_S),
        Check("certificate", lambda: reach.certificate(url), reach.LIMIT_S),
        Check("viewer", lambda: reach.viewer(url), reach.LIMIT_S),
    ]


def _here(read: Callable[[], Settings], path: Path | None, stun: str | None) -> list[Check]:
    settings, configuration = _configuration(read, path)
    network = network_of(settings, stun)
    running = ports.is_running(network)
    own = addresses.own_addresses()
    prepared = cache(lambda: prepare(settings, _driver(settings)))  # encoders are tried once
    return [
        Check("configuration", lambda: configuration),
        Check("TCP port", lambda: ports.tcp_port(network, running=running)),
        Check("UDP port", lambda: ports.udp_port(network, running=running)),
        Check("addresses", lambda: addresses.local_addresses(network, own)),
        Check("public address", lambda: addresses.world_address(network, own), 20.0),
        Check("firewall", lambda: addresses.firewall(network)),
        Check("certificate", lambda: certificate.certificate(network, _now())),
        Check("files", lambda: files(settings)),
        *sign_in.checks(settings),
        *door.checks(settings, _now().timestamp(), running=running),
        Check("picture size", lambda: machine.picture_size(prepared()), _ENCODERS_S),
        Check("camera", lambda: devices.camera(prepared().settings, running=running), _DEVICE_S),
        *_cameras(settings, prepared, running=running),
        Check("microphone", lambda: devices.microphone(settings, running=running), _DEVICE_S),
        Check("serial port", lambda: devices.serial_port(settings, running=running), _DEVICE_S),
        Check("clock", machine.clock),
        Check("encoder", lambda: machine.encoder(*prepared().driving_view), _ENCODERS_S),
        Check("processor", lambda: machine.processor(*prepared().driving_view), _ENCODERS_S),
        Check("disk", lambda: machine.disk(state_dir.find(settings.server.state_dir))),
        Check("UDP buffer", machine.udp_buffer),
        Check("open files", lambda: machine.open_files(settings)),
        Check("threads", lambda: machine.further_threads(running=running)),
        *(
            Check(f"hook {number}", partial(_hook, number, one))
            for number, one in enumerate(settings.hook, 1)
        ),
        *(
            [Check("MQTT broker", lambda: _broker(settings), _BROKER_S)]
            if settings.mqtt.url
            else []
        ),
    ]


def _driver(settings: Settings) -> Driver | None:
    """Return the driver, None if it cannot be built, which other checks report."""
    try:
        return make_driver(settings.robot, SystemClock())
    except WaxError:
        return None


def _cameras(settings: Settings, prepared: Callable[[], Prepared], *, running: bool) -> list[Check]:
    """Return a check for each camera other than the driving view."""

    def check(number: int) -> Check:
        def look() -> Verdict:
            sized = prepared().settings
            return devices.further_camera(sized, sized.camera[number], running=running)

        return Check(f"camera {settings.camera[number].name}", look, _DEVICE_S)

    return [check(number) for number in range(len(settings.camera))]


def _hook(number: int, hook: HookSettings) -> Verdict:
    """Check whether a hook can sign, without posting; raises `StartError`."""
    read_secret(hook.secret_file, f"hook[{number - 1}].secret_file")
    return ok(f"Events go to {hook.host}, signed; `wax hook test` tries it.")


def _broker(settings: Settings) -> Verdict:
    """Try what this server does there; raises `BrokerError` or `StartError`."""
    link = broker_link(settings, SystemClock())
    n_untried = link.check(published_topics(settings))
    told = f"{link.name} accepts this server, and commands arrive; topics begin with"
    told += f" {topic_of(settings)}/. It takes what this server publishes"
    if n_untried:
        told += f", as far as that can be tried; at {n_untried} topics, the host sees it later"
    return ok(f"{told}.")


def _configuration(read: Callable[[], Settings], path: Path | None) -> tuple[Settings, Verdict]:
    """Return the settings, or the defaults, and what is wrong with the file."""
    try:
        settings = read()
    except ConfigError as error:
        advice = "Correct it; the checks below take the defaults instead."
        return config.load(None), bad(f"{error}", advice)
    if path is None:
        return settings, ok("There is no --config FILE: the defaults are checked.")
    return settings, ok(f"{path} is valid.")


def _now() -> datetime.datetime:
    return datetime.datetime.now(datetime.UTC)


def _line(name: str, verdict: Verdict) -> str:
    line = f"{verdict.level:<8} {name:<15} {verdict.sentence}"
    return f"{line}\n{'':<24} → {verdict.advice}" if verdict.advice else line


def _tree(name: str, verdict: Verdict) -> dict[str, str]:
    return {
        "check": name,
        "level": verdict.level,
        "sentence": verdict.sentence,
        "advice": verdict.advice,
    }
