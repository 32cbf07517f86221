"""Stock Firefox: the ways to drive other than keys, and what it says without WebRTC."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness import gamepad, toml
from e2e.harness.bidi import firefox
from e2e.harness.installed import FIREFOX, installed
from e2e.harness.robot import moves, stands_still, undisturbed
from e2e.harness.wait import eventually
from e2e.test_firefox import PROBE, button, reads

if TYPE_CHECKING:
    from e2e.conftest import Serve
    from e2e.harness.bidi import Firefox

pytestmark = pytest.mark.timeout(120)

WORDS: Final = Path(__file__).parents[1] / "web/src/words/en/first.json"
TOUCH_SCREEN: Final = {"ui.primaryPointerCapabilities": 1, "ui.allPointerCapabilities": 1}
"""Fingers are all that points."""
IN_FRONT: Final = "document.hasFocus = () => true"
"""A headless Firefox never has the focus, whatever its window is told or clicked."""
HOLD_S: Final = 0.8
"""So long is watched whether the robot moves."""


async def _middle(window: Firefox, selector: str) -> dict[str, Any]:
    """Return where an element is in the window, and half its height, after it was scrolled to."""
    box: dict[str, Any] = await window.evaluate(f"""(() => {{
        const one = document.querySelector({json.dumps(selector)});
        one.scrollIntoView({{ block: "nearest" }});
        const {{ left, top, width, height }} = one.getBoundingClientRect();
        return {{ x: left + width / 2, y: top + height / 2, half: height / 2 }};
    }})()""")
    return box


def _at(x: float, y: float) -> dict[str, Any]:
    return {"type": "pointerMove", "x": round(x), "y": round(y)}


DOWN: Final = {"type": "pointerDown", "button": 0}
UP: Final = {"type": "pointerUp", "button": 0}


@pytest.mark.full
async def test_firefox_drives_by_joystick_and_gamepad(serve: Serve, tmp_path: Path) -> None:
    """A finger's push moves the robot; a gamepad does once it was chosen by its Start."""
    profile = tmp_path / "profile"
    profile.mkdir()
    script = PROBE.read_text(encoding="utf-8")
    async with (
        serve(tmp_path, toml.CARD) as server,
        firefox(installed(*FIREFOX), profile, script, preferences=TOUCH_SCREEN) as window,
    ):
        await window.goto(server.url)
        await eventually(
            lambda: window.evaluate("waxProbe.playing()"), "the picture plays", within_s=20
        )
        await window.evaluate(button("Join the queue"))
        await reads(window, "You are driving")

        async def touches() -> bool:
            box = await _middle(window, '[aria-label="Joystick"]')
            up = _at(box["x"], box["y"] - 0.8 * box["half"])
            await window.pointer("touch", _at(box["x"], box["y"]), DOWN, up)
            moved = await moves(server, during_s=HOLD_S)
            await window.pointer("touch", UP)
            assert await stands_still(server)
            return moved

        assert await undisturbed(server, touches)
        await window.evaluate(IN_FRONT)
        await window.evaluate(f"({gamepad.SCRIPT})()")
        await window.evaluate("waxPad.plug()")
        await window.evaluate("waxPad.push(1, -1)")
        assert not await moves(server, during_s=HOLD_S)
        await window.evaluate("waxPad.push(1, 0)")
        for is_down in ("true", "false"):
            await window.evaluate(f"waxPad.press({gamepad.START}, {is_down})")
            await asyncio.sleep(0.3)

        async def pushes() -> bool:
            await window.evaluate("waxPad.push(1, -1)")
            moved = await moves(server, during_s=HOLD_S)
            await window.evaluate("waxPad.push(1, 0)")
            assert await stands_still(server)
            return moved

        assert await undisturbed(server, pushes)


async def test_firefox_without_webrtc_says_so(serve: Serve, tmp_path: Path) -> None:
    """Where its user has switched WebRTC off, the page says that, and what to do."""
    path = installed(*FIREFOX)
    profile = tmp_path / "profile"
    profile.mkdir()
    off = {"media.peerconnection.enabled": False}
    words = json.loads(WORDS.read_text(encoding="utf-8"))
    async with (
        serve(tmp_path, toml.CARD) as server,
        firefox(path, profile, "", preferences=off) as window,
    ):
        await window.goto(server.url)
        for name in ("cannot", "no_webrtc", "switched_off", "what_to_do"):
            await reads(window, words[f"support.{name}"])
