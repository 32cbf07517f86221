"""The person aboard the simulated robot, who follows a script of the configuration (pure).

Operators can practise with it, and a host can show them what they will see, before anybody sits in
a real chair.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.driver.hand import HandReading

if TYPE_CHECKING:
    from wax.config.local import ActSettings, LocalSettings
    from wax.driver.interface import Ask


_ASKS: Final[dict[str, Ask]] = {
    "wait": "wait",
    "go_on": "go_on",
    "left": "left",
    "right": "right",
}


class ScriptedPerson:
    """Repeats the acts of `[local] script`, each `script_s` long."""

    def __init__(self, local: LocalSettings, began_s: float) -> None:
        self._acts = tuple(local.script)
        self._script_s = local.script_s
        self._began_s = began_s

    def reading(self, now_s: float) -> HandReading:
        """Return the hand's present reading; of two simultaneous acts the later one counts."""
        into_s = (now_s - self._began_s) % self._script_s
        act = next((one for one in reversed(self._acts) if _is_on(one, into_s)), None)
        if act is None:
            return HandReading(now_s)
        return HandReading(
            now_s,
            linear=act.linear,
            angular=act.angular,
            lateral=act.lateral,
            stop=act.press == "stop",
            ask=_ASKS.get(act.press),
        )


def _is_on(act: ActSettings, into_s: float) -> bool:
    return act.at_s <= into_s < act.at_s + act.for_s
