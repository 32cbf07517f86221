"""A Chromium shaped like the browser of a Quest, in which no offer is ever made."""

from __future__ import annotations

from typing import Any, Final

HEADSET: Final[dict[str, Any]] = {
    "user_agent": (
        "Mozilla/5.0 (X11; Linux x86_64; Quest 3) AppleWebKit/537.36 (KHTML, like Gecko)"
        " OculusBrowser/38.0.0.0.0 Chrome/136.0.0.0 VR Safari/537.36"
    ),
    "viewport": {"width": 1280, "height": 720},
    "has_touch": True,
}
"""How its browser presents itself; the hand's ray is a touch."""

SHAPE: Final = """
Reflect.deleteProperty(Navigator.prototype, "keyboard");
Object.defineProperty(navigator, "xr", {
  value: Object.assign(new EventTarget(), { isSessionSupported: async () => true }),
});
RTCPeerConnection.prototype.createOffer = () => new Promise(() => {});
"""
"""WebXR, no keyboard, and `createOffer` as unitreerobotics/xr_teleoperate#267 reports it."""

TOUCH: Final[dict[str, Any]] = {
    "id": "oculus-touch-v3 (right)",
    "mapping": "xr-standard",
    "buttons": 6,
}
"""A touch controller (WebXR Gamepads, 3.3): its stick is the axes 2 and 3, beside a touch pad."""
STICK_ACROSS: Final = 2
STICK_ALONG: Final = 3
SQUEEZE: Final = 1
