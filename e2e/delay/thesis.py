"""Chapter 5 and the predictions of 3.5 as data, quoted where the thesis has a quotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Said:
    """What the thesis says in one place: a section, and a figure where there is one."""

    text: str
    section: str
    figure: str | None = None

    @property
    def where(self) -> str:
        return f"thesis {self.section}" + (f", Figure {self.figure}" if self.figure else "")


@dataclass(frozen=True, slots=True)
class Pauses(Said):
    """Audible pauses, and the longest: 0 if there were none, None if the thesis does not say."""

    longest_ms: float | None = None

    is_told: bool = True
    """False for what follows from elsewhere in the thesis and was not tried on this network."""


def _none(text: str, section: str, figure: str) -> Pauses:
    return Pauses(text, section, figure, 0)


_CHOSEN: Final = Pauses(
    "none: “smooth audio playback for both LAN and the Internet”",
    "5.3, 6.1",
    longest_ms=0,
    is_told=False,
)
"""Why 500 ms were chosen. It was not tried on the local networks, where 400 ms had no pauses."""

AUDIO: Final[dict[str, dict[str, dict[int, Pauses]]]] = {
    "same-machine": {
        "": {
            100: Pauses("pauses, some “300 to 600 ms”", "5.2.1.2", "5.19", longest_ms=600),
            200: _none("none; one delay of 38 ms, not heard", "5.2.1.3", "5.22"),
            300: _none("none", "5.2.1.4", "5.25"),
            400: _none("none", "5.2.1.5", "5.28"),
            500: _CHOSEN,
        }
    },
    "lan": {
        "": {
            100: Pauses("1–4 per ½ s, up to 800 ms", "5.2.1.2", "5.20", 800),
            200: Pauses("1–3 per s, up to 400 ms", "5.2.1.3", "5.23", 400),
            300: _none("none", "5.2.1.4", "5.26"),
            400: _none("none", "5.2.1.5", "5.29"),
            500: _CHOSEN,
        }
    },
    "campus": {
        "": {
            100: Pauses("“almost every 100 ms there is a pause”", "5.2.1.2", "5.21"),
            200: Pauses("up to 3 per s, up to 800 ms", "5.2.1.3", "5.24", 800),
            300: Pauses("up to 5 per s, up to 400 ms", "5.2.1.4", "5.27", 400),
            400: _none("none; short reads at most once a second", "5.2.1.5", "5.30"),
            500: _CHOSEN,
        }
    },
    "internet-5m": {
        "Linux, Netscape 4.8": {
            100: Pauses("“a 400 ms pause for every audio MU”", "5.2.2.2", "5.35", 400),
            200: Pauses("about 2 per s", "5.2.2.3", "5.36"),
            300: Pauses("“once every two seconds”", "5.2.2.4", "5.37"),
            400: _none("none", "5.2.2.5", "5.38"),
        },
        "Windows, Netscape 4.8": {
            400: Pauses("about 2 per s, 150–170 ms", "5.2.2.5", "5.39", 170),
            500: _none("none", "5.2.2.6", "5.41"),
        },
        "Windows, Internet Explorer 6": {
            400: Pauses("1 per s, 300–500 ms", "5.2.2.5", "5.40", 500),
            500: _none("none", "5.2.2.6", "5.42"),
        },
        "Netscape 7.1, Java 2": {500: _none("none", "5.2.2.6", "5.43")},
    },
    "wireless-2m": {"": {500: _none("“smooth audio”", "5.4.1", "5.51")}},
    "wireless-1m": {"": {500: _none("“a smooth audio playback”", "5.4.2", "5.53")}},
    "modem-56k": {
        "": {500: Pauses("“about every 400 ms”, “as long as 2 seconds”", "5.4.3", "5.54", 2000)}
    },
}
"""Profile → client ("" if there was only one) → audio MU, ms."""

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
"""In 2004 the client timed a picture's transfer, from request to arrival, not its age from capture
to the screen, of which 6.1 says: “at least half a second goes by”."""


def words(profile: str, mu_ms: int) -> dict[str, Said]:
    """Return the thesis's words about a link by the names of `e2e.delay.measures`."""
    # Where several clients were tried, the first is the thesis's own measurement of the network.
    first = next(
        (by_mu[mu_ms] for by_mu in AUDIO.get(profile, {}).values() if mu_ms in by_mu), None
    )
    told: dict[str, Said | None] = {
        "picture_age_p50_ms": AGES.get(profile),
        "pictures_per_s": PICTURES.get(profile),
        "skew_p50_ms": SYNC.get(profile),
        "pauses_per_min": first,
    }
    return {name: said for name, said in told.items() if said is not None}
