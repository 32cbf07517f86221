"""Whatever colour a host chooses, it is legible in both themes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.web import colours
from wax.web.colours import BLACK, WHITE, contrast, parsed, written

STYLE = Path(__file__).parents[2] / "web" / "src" / "style"

any_colour = st.from_regex(r"#[0-9a-f]{6}", fullmatch=True)


def _grounds() -> list[colours.Colour]:
    """Return every background in the page's style sheets on which an accent lies."""
    css = "\n".join(file.read_text(encoding="utf-8") for file in sorted(STYLE.glob("*.css")))
    named = re.findall(r"--(?:ground|surface|sunken):\s*(#[0-9a-fA-F]{6});", css)
    return [parsed(one) for one in named]


LIGHT = [one for one in _grounds() if contrast(one, BLACK) > contrast(one, WHITE)]
DARK = [one for one in _grounds() if contrast(one, BLACK) < contrast(one, WHITE)]


@pytest.mark.parametrize(
    ("one", "other", "ratio"),
    [("#000000", "#ffffff", 21.0), ("#777777", "#ffffff", 4.48), ("#123456", "#123456", 1.0)],
)
def test_contrast_is_that_of_the_standard(one: str, other: str, ratio: float) -> None:
    """The values are those of WCAG's own examples and of common calculators."""
    assert contrast(parsed(one), parsed(other)) == pytest.approx(ratio, abs=0.005)
    assert contrast(parsed(other), parsed(one)) == contrast(parsed(one), parsed(other))


@given(any_colour)
def test_a_colour_is_written_as_it_was_read(text: str) -> None:
    """Parsing and writing lose nothing."""
    assert written(parsed(text)) == text


@given(any_colour)
def test_any_colour_is_legible_on_every_ground_of_the_page(accent: str) -> None:
    """As text on backgrounds, and under text, it has 4.5 : 1 in both themes."""
    assert len(LIGHT) >= 3
    assert len(DARK) >= 3
    for shades, grounds in ((colours.light(accent), LIGHT), (colours.dark(accent), DARK)):
        for ground in grounds:
            assert contrast(parsed(shades.accent), ground) >= 4.5
        for below in (shades.accent, shades.press):
            assert contrast(parsed(shades.on_accent), parsed(below)) >= 4.5
        assert contrast(WHITE, parsed(shades.driving)) >= 4.5


@given(any_colour)
def test_text_on_the_calm_ground_is_legible(accent: str) -> None:
    """The page's own text on the calm background has 4.5 : 1 in both themes."""
    assert contrast(parsed(colours.light(accent).calm), parsed("#18211d")) >= 4.5
    assert contrast(parsed(colours.dark(accent).calm), parsed("#e8eeea")) >= 4.5


@pytest.mark.parametrize("accent", ["#0b6b4c", "#7a1fa2", "#8b0000"])
def test_a_colour_that_is_legible_stays_as_it_is(accent: str) -> None:
    """Only illegible colours are changed."""
    assert colours.light(accent).accent == accent


def test_the_hue_stays() -> None:
    """A pale yellow becomes a dark yellow, not a grey."""
    red, green, blue = parsed(colours.light("#ffee88").accent)
    assert red > blue * 1.4
    assert green > blue * 1.4
