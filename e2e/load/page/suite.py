"""The suite: the first picture over two lines, main thread, memory, pictures, and every input."""

from __future__ import annotations

from functools import partial
from typing import Final

from e2e.load.page import main_thread, presented
from e2e.load.page.first_picture import first_picture
from e2e.load.page.input_to_gate import input_to_gate
from e2e.load.page.memory import memory
from e2e.load.page.ways import WAYS
from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Suite, measured

_LOADS: Final = "openings of the link"

SUITE: Final = Suite(
    name="page",
    about="Measure what the page takes: the first picture, work, memory, and inputs.",
    measures=(*SERVER, *PAGE, "web/src/**/*.css", "web/index.html", *FIRMWARE),
    columns=("median", "p95", "p99", "max"),
    cases=(
        measured(
            "first-picture/internet-5m",
            20,
            partial(first_picture, "internet-5m", 1000.0, "stock aiortc’s page, a bare video"),
            _LOADS,
            3,
        ),
        measured(
            "first-picture/modem-56k",
            5,
            partial(first_picture, "modem-56k", 25_000.0, None),
            _LOADS,
            1,
        ),
        measured("main-thread", 5, main_thread.main_thread, f"times {main_thread.SECONDS:g} s", 1),
        measured("presented", 10, presented.presented, f"pairs of {presented.SECONDS:g} s", 1),
        *(
            measured(f"input/{way.key}", 220, partial(input_to_gate, way), "presses", 15)
            for way in WAYS
        ),
        measured("memory", 30, memory, "minutes of driving", 2),
    ),
    notes=(
        "First picture: from the start of the page’s navigation to the second picture that is"
        " presented and differs from the first, in a browser without a past, whose first page is"
        " not counted. Stock includes what aiortc waits for the browser’s mDNS names.",
        "Main thread: Chromium’s own count of the time in tasks, while a key is held and the test"
        " card plays at 30 fps; long tasks by the browser’s observer.",
        "Pictures presented: by the compositor’s count, the page while it drives and a bare"
        " <video> with a connection to the same server in turn, each alone in the same browser.",
        "Inputs: from the time stamp of the browser’s event, for the gamepad from its injected"
        " change, on one machine. The gate’s own moment is before the frame is on the line. A touch"
        " is emulated, and headless Chromium takes up to a frame to tell the page of it.",
        "Memory: Chromium’s JSHeapUsedSize after a collection; what grows is the slope of the"
        " second half, over the whole time.",
    ),
)
