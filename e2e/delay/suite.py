"""The suite: how old picture, sound and commands are, how far apart, and how sharp the picture."""

from __future__ import annotations

import asyncio
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.delay.browser import open_browser
from e2e.delay.judging import COLUMNS, OURS, judged
from e2e.delay.names import AGE, ARRIVAL, GIVEN, SHARPNESS, SYSTEMS
from e2e.delay.plan import planned
from e2e.delay.voice.command_age import SECONDS, command_age
from e2e.delay.voice.mouth_to_speaker import mouth_to_speaker
from e2e.delay.voice.silenced import muted
from e2e.delay.watch import repeated
from e2e.instrument.error import own_error
from e2e.link import Link
from e2e.load.page.first_picture import first_picture
from e2e.load.page.input_to_gate import input_to_gate
from e2e.load.page.ways import WAYS
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite, measured

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.delay.plan import Planned
    from e2e.measure.row import Row


async def _instrument(n: int) -> list[Row]:
    """Measure the instrument's own error, once, whatever `n` is."""
    with TemporaryDirectory(prefix="wax-delay-") as folder:
        async with Link("same-machine") as link, open_browser(link) as browser:
            return await own_error(link, browser, Path(folder))


def _of(one: Planned) -> Case:
    seconds = f"times {one.cell.seconds:g} s of {SYSTEMS[one.cell.system]} at {one.cell.size}"
    return Case(
        one.cell.variant,
        seconds,
        one.n,
        lambda n: asyncio.run(repeated(one.cell, n)),
        minutes=one.minutes,
        long=one.long,
    )


def derive(rows: list[Row]) -> list[Row]:
    """Judge the cells; the judged quantile of a timed figure is in WAX's column."""
    by_key = {row.key: row for row in rows if "cell" not in row.detail}
    own = [row for row in by_key.values() if row.key.startswith("instrument/")]
    return [*own, *judged(rows), *_timed(by_key, [row.key for row in own])]


def _timed(by_key: dict[str, Row], but: Sequence[str]) -> Iterator[Row]:
    """Put a peer's value into its column, and keep the worse of a press and its release."""
    for key, row in by_key.items():
        if key in but or ": " in key:
            continue
        worse = max(
            (row, by_key.get(f"{key}: release", row)),
            key=lambda one: (one.met is False, one.values.get(one.judged) or 0.0),
        )
        stock = by_key.get(f"{key}: stock")
        values = {OURS: worse.values.get(worse.judged)}
        if stock is not None:
            values[SYSTEMS["stock"]] = stock.values.get(row.judged)
        what = row.what if worse is row else f"{row.what}, pressed or let go"
        update: dict[str, Any] = {"what": f"{what}, {row.judged}", "values": values, "judged": OURS}
        kept = ("spread", "met", "goal", "n")
        update |= {name: getattr(worse, name) for name in kept}
        yield row.model_copy(update=update)


SUITE: Final = Suite(
    name="delay",
    about="Measure how old picture, sound and commands are on each kind of link, and how sharp the "
    "picture is, beside peers.",
    measures=(*SERVER, *PAGE, "web/src/**/*.css", "web/index.html", *FIRMWARE),
    columns=COLUMNS,
    cases=(
        measured("instrument", 1, _instrument, "the instrument’s own error", 1, minutes=0.6),
        *map(_of, planned()),
        *(
            measured(
                f"first-picture/{profile}",
                n,
                partial(first_picture, profile, goal_ms, peer),
                "openings of the link",
                quick,
                minutes=1.7,
            )
            for profile, n, quick, goal_ms, peer in (
                ("internet-5m", 8, 3, 1000.0, "stock aiortc’s page, a bare video"),
                ("modem-56k", 3, 1, 25_000.0, None),
            )
        ),
        *(
            measured(
                f"input/{way.key}", 80, partial(input_to_gate, way), "presses", 15, minutes=0.9
            )
            for way in WAYS
        ),
        measured(
            "mouth-to-speaker/internet-5m",
            40,
            partial(mouth_to_speaker, "internet-5m", 200.0),
            "half seconds of speech, said and played",
            10,
            minutes=1.1,
        ),
        measured("mute", 20, partial(muted, 300.0), "times while somebody speaks", 3, minutes=1.6),
        measured(
            "command-age/modem-56k",
            2,
            partial(command_age, "modem-56k", 40.0),
            f"pairs of {SECONDS:g} s, speaking and silent",
            1,
            minutes=2.3,
        ),
    ),
    derive=derive,
    notes=(
        "Judged is the median over the repetitions; what stands beside was measured once.",
        AGE,
        SHARPNESS,
        ARRIVAL,
        "Age of the sound: from capture to the ear, a sound device (PulseAudio’s null sink) whose "
        "output is recorded, so that the browser’s way to the device is included. Concealed is "
        "what was heard and never sent, stretched what was heard twice.",
        "Driving on the modem: the operator’s page holds a key and sends 20 set-points a second; "
        "the commands’ round trip is that of the pings that share the channel with them.",
        *GIVEN,
        "First picture: from the start of the page’s navigation to the second picture that is "
        "presented and differs from the first, in a browser without a past.",
        "Inputs: from the time stamp of the browser’s event, for the gamepad from its injected "
        "change, on one machine. A touch is emulated, and headless Chromium takes up to a frame to "
        "tell the page of it.",
        "Voice: from when Chromium’s microphone, which is fed from a file, has begun to hear a "
        "piece of speech to when a sound device at the robot plays it; silence from when the "
        "button is pressed on the host’s page to the end of the last sound at that device; a "
        "command’s age by the difference of the quantiles with and without a voice.",
    ),
)
