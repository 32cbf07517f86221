"""The part of the instrument that asks the page and the ear, and keeps their answers."""

from __future__ import annotations

import json
from base64 import b64decode
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from e2e.delay.readings import Pictures, Readings, Sound
from e2e.instrument.sharpness import Look
from e2e.instrument.stamps import whole_ms
from e2e.measure.errors import MeasureError
from wax.protocol.messages import SoundReport

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.measure.ear import Ear

_PARTS: Final = ("clock", "hooks", "video_probe", "counts", "commands", "main")
NAME: Final = "__waxLab"


def preload(name: str = NAME) -> str:
    """Return the script to run before any of the page's; two with different names share a page."""
    folder = Path(__file__).parent / "page"
    parts = [(folder / f"{part}.js").read_text(encoding="utf-8") for part in _PARTS]
    known = {"NAME": name, "SOUND_REPORT": list(SoundReport.model_fields)}
    constants = [f"const {one} = {json.dumps(value)};" for one, value in known.items()]
    return "\n".join(["(() => {", *constants, *parts, "})();"])


PRELOAD: Final = preload()


class Instrument:
    """Reads one page and records its browser's sound, from now on.

    `evaluate` runs an expression in the page, awaits promises, returns JSON values. The page keeps
    the last 10 min at most; each call of `readings` fetches what is new. If the page is reloaded,
    its readings since the last call are lost.
    """

    def __init__(
        self, evaluate: Callable[[str], Awaitable[Any]], ear: Ear, *, name: str = NAME
    ) -> None:
        self._evaluate = evaluate
        self.tap = ear.tap()
        self._at = f"window[{name!r}]"
        self._load: float | None = None
        self._readings: Readings | None = None

    async def sees_picture(self) -> bool:
        return bool(await self._evaluate(f"{self._at}?.sees() ?? false"))

    async def readings(self) -> Readings:
        """Return everything from the page's opening until now.

        Raises `MeasureError` if the instrument was never in the page.
        """
        # As text, which is transferred sooner than so many values.
        taken = await self._evaluate(f"JSON.stringify({self._at}?.take() ?? null)")
        if taken is not None and (found := json.loads(taken)) is not None:
            self._take(found)
        if self._readings is None:
            raise MeasureError(
                "The instrument is not in this page: add PRELOAD before the page is opened."
            )
        _extend(self._readings.sound, Sound.of(self.tap.take()))
        self._readings.first_sound_ms = self.tap.first_ms
        # A copy, which does not grow later.
        return self._readings.model_copy(deep=True)

    async def look(self, times: int, every_s: float) -> None:
        """Look at the whole picture from now on, so often and so many times."""
        await self._evaluate(f"{self._at}.look({times}, {1000 * every_s})")

    async def looks(self) -> list[Look]:
        """Return what was seen; to hand over that many pixels disturbs the page, so do it last."""
        found = []
        while (seen := await self._evaluate(f"{self._at}.handOver()")) is not None:
            plane = np.frombuffer(b64decode(seen["luma"]), np.uint8)
            luma = plane.reshape(seen["height"], seen["stride"])[:, : seen["width"]]
            found.append(Look(seen["at_ms"], luma))
        return found

    def _take(self, taken: dict[str, Any]) -> None:
        known = self._readings
        if known is None or (known.first_picture_ms is None and self._load != taken["load"]):
            # The blank page before the real one does not count.
            known = self._readings = Readings(opened_ms=taken["opened_ms"])
            self._load = taken["load"]
        if known.first_picture_ms is None:
            known.first_picture_ms = taken["first_picture_ms"]
        _extend(known.pictures, _pictures(taken["pictures"]))
        for name in ("counters", "player_sound", "commands", "set_points", "connections"):
            columns = getattr(known, name)
            _extend(columns, type(columns)(**taken[name]))


def _pictures(taken: dict[str, list[Any]]) -> Pictures:
    stamps = taken.pop("stamp40_ms")
    whole = [
        None if stamp is None else whole_ms(stamp, at)
        for stamp, at in zip(stamps, taken["at_ms"], strict=True)
    ]
    return Pictures(stamp_ms=whole, **taken)


def _extend(known: Any, more: Any) -> None:
    for column in type(known).model_fields:
        getattr(known, column).extend(getattr(more, column))
