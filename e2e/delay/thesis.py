"""Chapter 5 and the predictions of 3.5 as data, in the thesis's own words where it gave words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Said:
    """What the thesis says in one place, and where: a section, and a figure where there is one."""

    text: str
    section: str
    figure: str | None = None

    @property
    def where(self) -> str:
        return f"thesis {self.section}" + (f", Figure {self.figure}" if self.figure else "")


_CHOSEN: Final = Said("none: “smooth audio playback for both LAN and the Internet”", "5.3, 6.1")
"""Why 500 ms were chosen. It was not tried on the local networks, where 400 ms were clean."""
PAUSES: Final[dict[str, dict[int, Said]]] = {
    "same-machine": {
        100: Said("pauses, some “300 to 600 ms”", "5.2.1.2", "5.19"),
        200: Said("none; one delay of 38 ms, not heard", "5.2.1.3", "5.22"),
        300: Said("none", "5.2.1.4", "5.25"),
        400: Said("none", "5.2.1.5", "5.28"),
        500: _CHOSEN,
    },
    "lan": {
        100: Said("1–4 per ½ s, up to 800 ms", "5.2.1.2", "5.20"),
        200: Said("1–3 per s, up to 400 ms", "5.2.1.3", "5.23"),
        300: Said("none", "5.2.1.4", "5.26"),
        400: Said("none", "5.2.1.5", "5.29"),
        500: _CHOSEN,
    },
    "campus": {
        100: Said("“almost every 100 ms there is a pause”", "5.2.1.2", "5.21"),
        200: Said("up to 3 per s, up to 800 ms", "5.2.1.3", "5.24"),
        300: Said("up to 5 per s, up to 400 ms", "5.2.1.4", "5.27"),
        400: Said("none; short reads at most once a second", "5.2.1.5", "5.30"),
        500: _CHOSEN,
    },
    "internet-5m": {
        100: Said("“a 400 ms pause for every audio MU”", "5.2.2.2", "5.35"),
        200: Said("about 2 per s", "5.2.2.3", "5.36"),
        300: Said("“once every two seconds”", "5.2.2.4", "5.37"),
        400: Said("none", "5.2.2.5", "5.38"),
        500: Said("none", "5.2.2.6", "5.41"),
    },
    "wireless-2m": {500: Said("“smooth audio”", "5.4.1", "5.51")},
    "wireless-1m": {500: Said("“a smooth audio playback”", "5.4.2", "5.53")},
    "modem-56k": {500: Said("“about every 400 ms”, “as long as 2 seconds”", "5.4.3", "5.54")},
}
"""Audible pauses by profile and audio MU, ms; of several clients that were tried, the first's."""

SYNC: Final[dict[str, Said]] = {
    "same-machine": Said("“near-perfect synchronization”", "5.3.1", "5.45"),
    "lan": Said("“the same degree”: near perfect", "5.3.1", "5.46"),
    "campus": Said("“in sync”; 0–1 video pauses per s", "5.3.1", "5.48"),
    "internet-5m": Said("“doesn't exceed 100 ms”; 0–2 video pauses per s", "5.3.2", "5.49"),
    "modem-56k": Said("picture recent, “drifting does not occur”", "5.4.3, 6.1", "5.55"),
}
PICTURES: Final[dict[str, Said]] = {
    "same-machine": Said("10", "5.2.1.1, 6.1", "5.16"),
    "lan": Said("10", "5.2.1.1, 6.1", "5.17"),
    "campus": Said("10", "5.2.1.1, 6.1", "5.18"),
    "internet-5m": Said("10", "6.1", "5.34"),
    "wireless-2m": Said("as with 5 Mbit/s", "5.4.1", "5.50"),
    "wireless-1m": Said("as with 2 Mbit/s", "5.4.2", "5.52"),
    "modem-56k": Said("“a frame every 1.5 to 3 seconds”", "5.4.3", "5.55"),
    "isdn-64k": Said("predicted: “one frame every two seconds”", "3.5"),
    "dual-modem": Said("predicted: “1-3 fps”", "3.5"),
}
"""How many pictures a second."""
AGES: Final[dict[str, Said]] = {
    "same-machine": Said("transfer under 1 ms, spikes to 9", "5.2.1.1", "5.16"),
    "lan": Said("transfer as on the same machine", "5.2.1.1", "5.17"),
    "campus": Said("transfer “0 or 10” ms, once 200", "5.2.1.1", "5.18"),
    "internet-5m": Said("transfer 47–94 ms", "5.2.2.1", "5.34"),
    "modem-56k": Said("“quite recent”", "5.4.3", "5.55"),
}
"""In 2004 the client timed a picture's transfer, from asking to having it, not its age from capture
to the screen, of which 6.1 says: “at least half a second goes by”."""


def words(profile: str, mu_ms: int) -> dict[str, Said]:
    """Give the thesis's words about a link by the names of `e2e.delay.measures`."""
    told: dict[str, Said | None] = {
        "picture_age_p50_ms": AGES.get(profile),
        "pictures_per_s": PICTURES.get(profile),
        "skew_p50_ms": SYNC.get(profile),
        "pauses_per_min": PAUSES.get(profile, {}).get(mu_ms),
    }
    return {name: said for name, said in told.items() if said is not None}
