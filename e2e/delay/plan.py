"""Which cells are measured, how often, and which only in a long run."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.delay.cell import Cell
from e2e.delay.names import LINKS, NARROW, PEERS, SYSTEMS, WIRED, SystemName, profile
from e2e.link import DRIVE
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


REPEATS: Final = 3
MATRIX_S: Final = 30.0
DRIVES: Final = "WAX_DRIVES"
"""The environment variable that names a folder of recorded drives: mahimahi's traces, NAME.down and
NAME.up."""
_RUN_S: Final = 10.0
"""Link, browser, server, first picture, reading and sharpness, in addition to the measured time."""
_FIRST_BYTES: Final = 100_000
"""The bytes that a first picture takes over the link."""
_JOIN_S: Final = 0.5
"""For each viewer of the crowd."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A cell, and how often it is measured; a `long` one is never published."""

    cell: Cell
    n: int
    long: bool = False

    @property
    def minutes(self) -> float:
        rate_bps = profile(self.cell.profile).down.rate_bps
        loading_s = 8 * _FIRST_BYTES / rate_bps if rate_bps else 0.0
        joining_s = _JOIN_S * (self.cell.viewers - 1)
        return self.n * (_RUN_S + loading_s + self.cell.seconds + joining_s) / 60


_MODEM: Final[dict[str, Any]] = {"drives": True, "seconds": 20.0}
_LARGE: Final[dict[str, Any]] = {"size": "1280x720"}
_FILM: Final[dict[str, Any]] = {"size": "1280x720-film"}
_SEVERAL: Final[tuple[tuple[Any, ...], ...]] = (
    ("same-machine", "operator"),
    ("same-machine", "audio-master"),
    ("same-machine", "operator", _LARGE),
    ("internet-5m", "operator"),
    ("internet-5m", "operator", _LARGE),
    ("internet-5m", "livekit-whip", _LARGE),
    ("internet-5m", "operator", _FILM),
    ("wireless-1m", "operator", _FILM),
    ("internet-5m", "audio-master"),
    ("wireless-1m", "operator"),
    ("wireless-1m", "audio-master"),
    ("modem-56k", "operator", _MODEM),
    ("wifi-bad", "operator"),
    ("wifi-bad", "audio-master"),
    ("cafe", "operator"),
    ("cafe", "audio-master"),
    ("stalls", "audio-master", {"seconds": 20.0}),
    ("satellite", "audio-master"),
    ("step-down", "operator", {"seconds": 28.0}),
    ("outage", "operator"),
)
"""Profile, system and what differs from a default cell; each several times. One peer is among
them: beside its row in the README one run is mostly chance."""
_BESIDE: Final[tuple[tuple[Any, ...], ...]] = (
    *product(("same-machine", "internet-5m"), ("thesis", *PEERS)),
    *product(("same-machine",), PEERS, (_LARGE,)),
    *product(("internet-5m",), ("stock", "livekit"), (_LARGE,)),
    *product(("internet-5m", "wireless-1m"), PEERS, (_FILM,)),
    ("same-machine", "operator", {"player": "browser"}),
    ("wireless-1m", "thesis"),
    *product(("wireless-1m",), PEERS),
    ("modem-56k", "thesis", {"seconds": 20.0}),
    ("modem-56k", "stock", {"seconds": 20.0}),
    ("modem-56k", "operator", {"player": "browser", **_MODEM}),
    ("wifi-bad", "audio-master", {"player": "browser"}),
    ("wifi-bad", "stock"),
    ("wifi-bad", "livekit-whip"),
    ("cafe", "stock"),
    ("cafe", "livekit-whip"),
    ("stalls", "audio-master", {"player": "browser", "seconds": 20.0}),
    ("stalls", "stock", {"seconds": 20.0}),
    ("satellite", "stock"),
)
"""The cells for comparison, or shown next to a goal's; each once."""
_CROWDED: Final[tuple[SystemName, ...]] = ("thesis", "operator", "stock")
"""What the measured page uses; the crowd around it are observers under audio-master."""
_DRIVEN: Final[tuple[SystemName, ...]] = ("operator", "audio-master", "stock")
_CROWD: Final = ("same-machine", "operator", {"viewers": 41, "slow": 4})


def planned() -> list[Planned]:
    """Return the cells, the published ones by link; raises `MeasureError` without any drives."""
    once = [
        *(Planned(_cell(*one), REPEATS) for one in _SEVERAL),
        *(Planned(_cell(*one), 1) for one in _BESIDE),
        Planned(_cell(*_CROWD), 2),
    ]
    once.sort(key=lambda one: (LINKS.index(one.cell.profile), one.n == 1))
    return [*once, *(Planned(cell, 1, long=True) for cell in _long())]


def _long() -> Iterator[Cell]:
    for name, mu_ms in product((*WIRED, *NARROW), (100, 200, 300, 400, 500)):
        yield _cell(name, "thesis", {"experiment": "units", "audio_mu_ms": mu_ms})
    for name, system in product(LINKS, SYSTEMS):
        yield _cell(name, system, {"experiment": "matrix", "seconds": MATRIX_S})
    for viewers, system in product((5, 9, 17), _CROWDED):
        yield _cell("same-machine", system, {"experiment": "crowds", "viewers": viewers})
    steady = {"experiment": "steady"}
    yield _cell("same-machine", "audio-master", {**steady, "seconds": 1800.0})
    yield _cell("modem-56k", "operator", {**steady, "seconds": 300.0, "drives": True})
    yield _cell("satellite", "audio-master", {**steady, "seconds": 600.0})
    for drive, system in product(_drives(), _DRIVEN):
        yield _cell(drive, system, {"experiment": "drive", "seconds": 60.0})


def _drives() -> Iterable[str]:
    folder = os.environ.get(DRIVES)
    if not folder:
        return []
    drives = sorted(str(path.resolve()) for path in Path(folder).glob(f"*{DRIVE}"))
    if not drives:
        raise MeasureError(f"{folder} has no recorded drive: no file ends in {DRIVE}")
    return drives


def _cell(name: str, system: SystemName, more: dict[str, Any] | None = None) -> Cell:
    return Cell.model_validate({"profile": name, "system": system, **(more or {})})
