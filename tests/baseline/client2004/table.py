"""The model's pauses on each connection, compared with the thesis's words."""

from __future__ import annotations

from functools import cache
from random import Random
from typing import TYPE_CHECKING, Final

from tests.baseline.client2004.client import Heard, Listening
from tests.baseline.client2004.scenes import RECORDER, SCENES
from tests.baseline.client2004.source import Recorder, SharedMemory

if TYPE_CHECKING:
    from tests.baseline.client2004.client import Serve
    from tests.baseline.client2004.scenes import Scene

MU_LENGTHS_MS: Final = (100, 200, 300, 400, 500)
CLEAN_PER_S: Final = 0.05
"""Fewer pauses than one in 20 s count as none: no run that the thesis shows is longer."""
FAR: Final = 2.0
"""Longest pauses that differ by more than this factor are listed."""
WITHOUT_FRAGMENTS: Final = Recorder(fragment_ms=0.0, hand_over_ms=0.0)

_SEEDS: Final = 4
_SECONDS: Final = 60.0
_FROM_S: Final = 25.0
"""Counted from here: 500 ms units and 512 ms fragments need 21 s to meet again, and until then
each unit is a little later than any before."""


@cache
def hear(
    scene: Scene, mu_ms: int, *, recorder: Recorder = RECORDER, serve: Serve = SharedMemory
) -> Heard:
    """Listen for four minutes in all, from four different moments; the same every time."""
    together = Heard(_SEEDS * _SECONDS)
    for seed in range(_SEEDS):
        heard = Listening(
            mu_ms=mu_ms,
            recorder=recorder,
            path=scene.path,
            client=scene.client,
            chance=Random(seed),
            seconds=_SECONDS,
            from_s=_FROM_S,
            serve=serve,
        ).run()
        together.pauses += heard.pauses
        together.blocks += heard.blocks
        together.given += heard.given
        together.skipped += heard.skipped
    return together


def is_clean(heard: Heard) -> bool:
    return heard.pauses_per_s < CLEAN_PER_S


def words(heard: Heard) -> str:
    """Describe the result in the thesis's terms."""
    if is_clean(heard):
        return "none"
    return (
        f"{heard.pauses_per_s:.1f} per s, up to {heard.longest_ms:.0f} ms, "
        f"silent {heard.silence:.0%}"
    )


def agreement() -> tuple[int, int]:
    """Return in how many cells both or neither have pauses, and of how many the thesis speaks."""
    both = [
        clean == is_clean(hear(scene, mu_ms))
        for scene in SCENES
        for mu_ms in MU_LENGTHS_MS
        if (clean := scene.was_clean(mu_ms)) is not None
    ]
    return sum(both), len(both)


def differences() -> list[str]:
    """Return the cells and figures in which the model differs from the thesis."""
    found = []
    for scene in SCENES:
        for mu_ms in MU_LENGTHS_MS:
            clean, heard = scene.was_clean(mu_ms), hear(scene, mu_ms)
            longest_ms = scene.longest_ms(mu_ms) or heard.longest_ms
            is_far = not longest_ms / FAR <= heard.longest_ms <= longest_ms * FAR
            if clean is not None and (clean != is_clean(heard) or (is_far and not clean)):
                found.append(
                    f"{scene.name}, {mu_ms} ms: thesis {scene.words(mu_ms)}; model {words(heard)}."
                )
    return [*found, *_figures()]


def _figures() -> list[str]:
    """Return what does not come out of Figures 5.33 and 5.44: halved, and from 14 to 4 pauses."""
    by_name = {scene.name: scene for scene in SCENES}
    found = []
    short, long = (hear(by_name["campus"], mu_ms) for mu_ms in (100, 200))
    if not 0.35 <= long.pauses_per_s / short.pauses_per_s <= 0.65:
        found.append(
            "Figure 5.33: on the campus 200 ms MUs halve the pauses of 100 ms; model "
            f"{short.pauses_per_s:.1f} to {long.pauses_per_s:.1f} per s."
        )
    short, long = (hear(by_name["Internet, Linux"], mu_ms) for mu_ms in (100, 200))
    pauses = round(14 * long.pauses_per_block / short.pauses_per_block)
    if not 3 <= pauses <= 5:
        found.append(
            "Figure 5.44: from 100 to 200 ms the pauses of the run fall from 14 to 4; model, over "
            f"as many blocks of sound, from 14 to {pauses}."
        )
    return found
