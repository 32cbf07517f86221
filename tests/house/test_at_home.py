"""The whole server with a broker, as seen from home."""

from __future__ import annotations

import asyncio
import json
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.house.mosquitto import AtHome, running
from tests.until import async_until

from wax.app import App
from wax.clock import SystemClock
from wax.config.settings import Settings
from wax.web import routes

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = [pytest.mark.system, pytest.mark.alone]

STOPPED_WITHIN_S = 0.1


def _flood(home: AtHome) -> None:
    """Send a thousand messages within a second."""
    for number in range(100):
        for _ in range(10):
            home.says("wax/rover/open/set", b"\xff" * (number + 1), qos=0)
        time.sleep(0.01)


async def test_the_robot_at_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Home sees, closes, opens and stops the robot; retained and flooding messages do nothing."""
    (tmp_path / "index.html").write_text("<!doctype html>")
    monkeypatch.setattr(routes, "PAGE", tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with running(tmp_path) as mosquitto, AtHome(mosquitto.port) as home:
        for name, payload in (("stop", "PRESS"), ("open", "OFF"), ("paused", "ON")):
            home.says(f"wax/rover/{name}/set", payload, retain=True)
        for topic in ("homeassistant/device/wax_rover/config", "wax/rover/open"):
            home.says(topic, b"\xff{garbage", retain=True)
        tree: dict[str, Any] = {
            "server": {"host": "127.0.0.1", "port": 0},
            "network": {"udp_port": 0},
            "video": {"source": "none"},
            "audio": {"source": "none"},
            "page": {"name": "Rover"},
            "mqtt": {"url": f"mqtt://127.0.0.1:{mosquitto.port}"},
        }
        app = App(settings=Settings.model_validate(tree), clock=SystemClock())
        stopped_s: list[float] = []
        stop = app._parts.driver.stop

        def noted_stop(turn: int) -> None:
            stopped_s.append(time.monotonic())
            stop(turn)

        monkeypatch.setattr(app._parts.driver, "stop", noted_stop)
        ready = asyncio.Event()
        running_app = asyncio.create_task(app.run(lambda _: ready.set()))
        await ready.wait()
        await async_until(lambda: home.value("wax/rover/open") == "ON")
        found = json.loads(home.value("homeassistant/device/wax_rover/config") or "")
        assert found["device"]["name"] == "Rover"
        await async_until(lambda: '"server.ready"' in "".join(home.events))
        assert home.value("wax/rover/paused") == "OFF"
        assert app._parts.control.latched is None

        home.says("wax/rover/open/set", "OFF")
        await async_until(lambda: home.value("wax/rover/open") == "OFF")
        home.says("wax/rover/open/set", "ON")
        await async_until(lambda: home.value("wax/rover/open") == "ON")

        flood = asyncio.create_task(asyncio.to_thread(_flood, home))
        await async_until(lambda: app._parts.house.counts["overtaken"] > 100)
        stopped_s.clear()
        pressed_s = time.monotonic()
        home.says("wax/rover/stop/set", "PRESS", qos=0)
        await async_until(lambda: app._parts.control.latched is not None)
        assert stopped_s[0] - pressed_s < STOPPED_WITHIN_S
        await flood
        await async_until(lambda: home.value("wax/rover/last_stop_reason") == "pressed (house)")
        assert app._parts.house.counts["garbage"] < 10
        assert home.value("wax/rover/open") == "ON"

        app.stop()
        await asyncio.wait_for(running_app, 5)
        await async_until(lambda: home.value("wax/rover/status") == "offline")
        types = [json.loads(event)["type"] for event in home.events]
    assert (types[0], types[-1]) == ("server.ready", "server.ending")
    assert "stop.pressed" in types
