"""What chapter 5.2 of the thesis says, and where it contradicts itself."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Said:
    """Of one connection: a text for each MU length in ms, and from which length it is clean.

    `longest_ms` is the longest pause, where the thesis gives one.
    """

    texts: dict[int, str]
    clean_from_ms: int
    longest_ms: dict[int, int]

    def is_clean(self, mu_ms: int) -> bool | None:
        """Return whether there were no pauses, None where the thesis does not say."""
        return mu_ms >= self.clean_from_ms if mu_ms in self.texts else None


SAID = {
    "same machine": Said(
        texts={100: "pauses, 300-600 ms", 200: "none", 300: "none", 400: "none"},
        clean_from_ms=200,
        longest_ms={100: 600},
    ),
    "LAN": Said(
        texts={
            100: "1-4 per half s, up to 800 ms",
            200: "1-3/s, up to 400 ms",
            300: "none",
            400: "none",
        },
        clean_from_ms=300,
        longest_ms={100: 800, 200: 400},
    ),
    "campus": Said(
        texts={
            100: "almost every MU",
            200: "up to 3/s, up to 800 ms",
            300: "up to 5/s, up to 400 ms",
            400: "none",
        },
        clean_from_ms=400,
        longest_ms={200: 800, 300: 400},
    ),
    "Internet, Linux": Said(
        texts={100: "400 ms at every MU", 200: "2/s", 300: "1 per 2 s", 400: "none"},
        clean_from_ms=400,
        longest_ms={100: 400},
    ),
    "Internet, Windows": Said(
        texts={400: "Netscape 2/s, 150-170 ms; IE 1/s, 300-500 ms", 500: "none"},
        clean_from_ms=500,
        longest_ms={400: 500},
    ),
}

CONTRADICTIONS = (
    "5.2.1.1 against 5.2.1.2: pictures of 8 kB took under 1 ms on the same machine and on the "
    "LAN as little, yet sound of 0.8 to 1.6 kB paused there for up to 800 ms. Those delays "
    "cannot be the cause: with a card without fragments the model has no pause there at all.",
    "5.2.1.2 and 5.2.1.3: four pauses in half a second of up to 800 ms, three a second of up to "
    "800 ms, five a second of up to 400 ms: more pause than there is time, unless both are bounds "
    "that are never met together.",
    "5.2.2.2 and 5.2.2.3 against Figure 5.44: a pause of 400 ms at every MU of 100 ms is two a "
    "second, and 200 ms has two a second too; the figure has 14 and 4. Its axis is the sequence, "
    "not time, which explains part of it.",
    "Text under Figure 5.44 against 5.2.2.5: there IE has more and shorter pauses than Netscape "
    "at 400 ms, here fewer (one a second, not two) and longer (300-500 ms, not 150-170).",
    "6.1 against 5.2.1.4: a LAN is said to need more than 400 ms; 300 was clean on it, and 400 "
    "on the campus.",
    "5.4.3 against 6.1: on the modem a pause about every 400 ms, and every 300 ms.",
)
