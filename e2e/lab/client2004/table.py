"""The table: thesis beside model, and in words where they differ."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from functools import partial
from random import Random
from typing import TYPE_CHECKING, Final

from e2e.lab.client2004.baseline import Baseline
from e2e.lab.client2004.client import Heard, listen
from e2e.lab.client2004.scenes import (
    CLIENT_REASONS,
    JAVA_2,
    PAGE,
    RECORDER,
    RECORDER_REASONS,
    SCENES,
    Scene,
)
from e2e.lab.client2004.source import Recorder, SharedMemory
from e2e.lab.client2004.thesis import CONTRADICTIONS, SAID

if TYPE_CHECKING:
    from e2e.lab.client2004.client import Serve
    from e2e.lab.client2004.path import Path

MU_LENGTHS_MS: Final = (100, 200, 300, 400, 500)
CLEAN_PER_S: Final = 0.05
"""Fewer pauses than one in 20 s count as none: no run that the thesis shows is longer."""

WITHOUT_FRAGMENTS: Final = Recorder(fragment_ms=0.0, hand_over_ms=0.0)

_SEEDS: Final = 4
_SECONDS: Final = 60.0
_FROM_S: Final = 25.0
"""Counted from here: 500 ms units and 512 ms fragments need 21 s to meet again, and until then
each unit is a little later than any before. What is heard before stands under the figures."""


def hear(
    scene: Scene,
    mu_ms: int,
    *,
    recorder: Recorder = RECORDER,
    path: Path | None = None,
    serve: Serve = SharedMemory,
) -> Heard:
    """Listen for four minutes in all, from four different moments; the same every time."""
    together = Heard(_SEEDS * _SECONDS)
    for seed in range(_SEEDS):
        heard = listen(
            mu_ms=mu_ms,
            recorder=recorder,
            path=path or scene.path,
            client=scene.client,
            chance=Random(seed),
            seconds=_SECONDS,
            from_s=_FROM_S,
            serve=serve,
        )
        together.pauses += heard.pauses
        together.blocks += heard.blocks
        together.given += heard.given
        together.skipped += heard.skipped
    return together


def is_clean(heard: Heard) -> bool:
    return heard.pauses_per_s < CLEAN_PER_S


def words(heard: Heard) -> str:
    """Say it as the thesis does."""
    if is_clean(heard):
        return "none"
    return (
        f"{heard.pauses_per_s:.1f}/s, up to {heard.longest_ms:.0f} ms, silent {heard.silence:.0%}"
    )


def table() -> str:
    """Make the whole text."""
    lines = [
        "Audible pauses of the 2004 client by connection and audio MU: thesis (5.2) | model",
        "",
    ]
    differ: list[str] = []
    far: list[str] = []
    for scene in SCENES:
        lines.append(f"{scene.name}: {scene.reasons}")
        said = SAID[scene.name]
        for mu_ms in MU_LENGTHS_MS:
            heard = hear(scene, mu_ms)
            text = said.texts.get(mu_ms, "-")
            lines.append(f"  {mu_ms} ms   {text:46} | {words(heard)}")
            if said.is_clean(mu_ms) not in (None, is_clean(heard)):
                differ.append(f"{scene.name}, {mu_ms} ms: thesis {text}; model {words(heard)}.")
            elif not 1 / 2 <= heard.longest_ms / said.longest_ms.get(mu_ms, heard.longest_ms) <= 2:
                far.append(f"{scene.name}, {mu_ms} ms: thesis {text}; model {words(heard)}.")
        lines.append("")
    lines += _section("Cells where one has pauses and the other has none", differ or ["none"])
    lines += _section("Cells whose longest pauses are more than twice apart", far or ["none"])
    lines += _section(
        "The same with a card without fragments: what the delays alone would do",
        [
            f"{scene.name}: "
            + "; ".join(
                f"{mu_ms} ms {words(hear(scene, mu_ms, recorder=WITHOUT_FRAGMENTS))}"
                for mu_ms in MU_LENGTHS_MS
            )
            for scene in SCENES
        ],
    )
    lines += _section("Figures", figures())
    lines += _section("Served by our own thesis policy (wax.sync.thesis)", bridge())
    lines += _section("Assumed of the server", RECORDER_REASONS)
    lines += _section("Assumed of the clients", CLIENT_REASONS)
    lines += _section("Where the thesis contradicts itself", CONTRADICTIONS)
    return "\n".join(lines)


def figures() -> list[str]:
    """Say what the model makes of Figures 5.32 to 5.44."""
    by_name = {scene.name: scene for scene in SCENES}
    lan = [hear(by_name["LAN"], mu_ms).silence for mu_ms in (100, 200)]
    campus = [hear(by_name["campus"], mu_ms) for mu_ms in (100, 200)]
    internet = [hear(by_name["Internet, Linux"], mu_ms) for mu_ms in (100, 200)]
    fall = internet[1].pauses_per_block / internet[0].pauses_per_block
    java_2 = hear(replace(by_name["Internet, Linux"], client=JAVA_2), 500)
    first = listen(
        mu_ms=500,
        recorder=RECORDER,
        path=by_name["LAN"].path,
        client=by_name["LAN"].client,
        chance=Random(0),
        seconds=_FROM_S,
    )
    return [
        f"5.32: on the LAN 200 ms MUs save about 50 % of the delay of 100 ms; model "
        f"{1 - lan[1] / lan[0]:.0%}.",
        f"5.33: on the campus 200 ms MUs halve the number of pauses; model, over as many blocks of "
        f"sound, {1 - campus[1].pauses_per_block / campus[0].pauses_per_block:.0%} fewer. By time "
        f"it does not: {campus[0].pauses_per_s:.1f}/s to {campus[1].pauses_per_s:.1f}/s.",
        f"5.44: from 100 to 200 ms the pauses of the run fall from 14 to 4; model, over as many "
        f"blocks of sound, from 14 to {14 * fall:.0f}.",
        f"5.43: with Java 2's blocks of 256 ms none at 500 ms; model {words(java_2)}.",
        f"5.41: no delay at all with 500 ms; model, in its first {_FROM_S:.0f} s, "
        f"{len(first.pauses)} pauses of up to {first.longest_ms:.0f} ms, then none.",
    ]


def bridge() -> list[str]:
    """Say what is heard when our own sender serves the same client, and what differs why."""
    whole = cut = clean = 0
    differ: list[str] = []
    delivered: list[str] = []
    for scene in SCENES:
        paged = replace(scene, client=PAGE)
        cells: list[str] = []
        for mu_ms in MU_LENGTHS_MS:
            ours = partial(Baseline, mu_ms)
            in_one_piece = hear(scene, mu_ms, recorder=WITHOUT_FRAGMENTS, serve=ours)
            whole += in_one_piece == hear(scene, mu_ms, recorder=WITHOUT_FRAGMENTS)
            heard, theirs = hear(scene, mu_ms, serve=ours), hear(scene, mu_ms)
            cut += heard == theirs
            if heard != theirs:
                differ.append(f"{scene.name}, {mu_ms} ms {words(heard)} ({words(theirs)})")
            cells.append(f"{mu_ms} ms {words(hear(paged, mu_ms, serve=ours))}")
            clean += is_clean(hear(paged, mu_ms, recorder=WITHOUT_FRAGMENTS, serve=ours))
        delivered.append(f"{scene.name} {', '.join(cells)}")
    count = len(SCENES) * len(MU_LENGTHS_MS)
    return [
        f"Sound that comes in one piece, as ours does, and what the client asks for taken for the "
        f"acknowledgement: in {whole} of {count} cells the same MUs leave at the same times, are "
        f"skipped and are heard.",
        f"The same with the card's fragments: in {cut} of {count} cells. In the others an MU waits "
        f"at the source for a client that is long about asking. The thesis says that it waits no "
        f"longer than its own length, and in other words until the next is ready (3.3). That is "
        f"the same where MUs come one by one; a card that hands over several at once is then "
        f"silent for longer. Our sender drops it after its length, the model keeps it until the "
        f"next is ready. Ours (model): {'; '.join(differ) or 'none'}.",
        f"Acknowledged on delivery, as our page does, and not when that client asks, which is when "
        f"its queue has room, and on Windows a turn-round later: {'; '.join(delivered)}.",
        f"On delivery and in one piece, which is how our baseline runs: {clean} of {count} cells "
        f"are clean. So the delays that the thesis prints give it no pauses: by this model those "
        f"of chapter 5.2 are the card's and the client's of 2004, and those in the lab the link's.",
    ]


def _section(title: str, paragraphs: list[str] | tuple[str, ...]) -> list[str]:
    lines = [title]
    for paragraph in paragraphs:
        lines += textwrap.wrap(paragraph, 100, initial_indent="  * ", subsequent_indent="    ")
    return [*lines, ""]
