"""The page keeps its promises for whatever a run has or lacks."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from e2e.lab.cell import Cell
from e2e.lab.figures import Figures, Pauses, Quantiles
from e2e.lab.readings import Pictures, Readings, Sound
from e2e.lab.report.page import html
from e2e.lab.report.reader import Page, a_cell, page_of
from e2e.lab.report.synthetic import START_MS, bare, failed, measured, run
from e2e.lab.results import CellResult

if TYPE_CHECKING:
    from e2e.lab.results import Run


def _everything() -> Run:
    cells = [
        measured(
            a_cell("E1", "lan", "thesis", audio_mu_ms=mu_ms),
            picture_ms=350,
            sound_ms=mu_ms,
            fps=10,
            pauses=[(1.0, 200.0), (5.0, 90.0)] if mu_ms < 300 else [],
        )
        for mu_ms in (100, 200, 300, 400, 500)
    ]
    cells += [measured(a_cell("E2", system="operator", repeat=repeat)) for repeat in (0, 1)]
    cells += [measured(a_cell("E2", system="operator", content="face"))]
    cells += [measured(a_cell("E3", "modem-56k", "thesis", audio_mu_ms=500), fps=0.5)]
    cells += [failed(a_cell("E3", "modem-56k", "livekit"), "The page did not load.")]
    cells += [measured(a_cell("E4", browser="firefox"), limits=["Firefox hides the concealment."])]
    cells += [measured(a_cell("E5", viewers=viewers)) for viewers in (1, 8)]
    cells += [
        measured(
            a_cell("E6", "outage", "operator", seconds=25.0),
            grows_from_s=5.0,
            grows_until_s=7.4,
            told={"changes_began_ms": START_MS + 3000.0},
        )
    ]
    return run(cells)


@cache
def _whole_page() -> str:
    return html(_everything())


def test_nothing_measured_is_a_page_that_says_so() -> None:
    """An empty run gives a page with every section, each saying that it has no cell."""
    page = page_of(run([], machine={}, instrument={}))
    assert "This run has no cells: nothing was measured." in page.words
    assert page.words.count("no cell") >= 7
    assert {"e1", "e2", "e3", "e4", "e5", "e6", "systems", "cells"} <= set(page.ids)


def test_the_page_is_one_file_without_script() -> None:
    """Nothing is fetched, nothing runs, plots are in the page; it is under 3 MB."""
    text = _whole_page()
    page = Page(text)
    assert page.tags.isdisjoint({"script", "link", "iframe", "object"})
    assert page.images
    assert all((image["src"] or "").startswith("data:image/") for image in page.images)
    assert all(image["alt"] for image in page.images)
    assert all(link.startswith("#") for link in page.links)
    assert "url(" not in text.partition("</style>")[0]
    assert len(text) < 3_000_000


def test_every_link_has_its_target() -> None:
    """Each link leads to an id that is there, and no id is there twice."""
    page = Page(_whole_page())
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))


def test_each_figure_names_its_cells() -> None:
    """Behind each figure stand the keys of all its cells, each with its own number."""
    cells = [
        measured(a_cell(repeat=repeat), picture_ms=ms) for repeat, ms in enumerate((100, 200, 300))
    ]
    for result, p50 in zip(cells, (100.0, 200.0, 300.0), strict=True):
        assert result.figures is not None
        result.figures.picture_age_ms = Quantiles(n=9, min=p50, p50=p50, p95=p50, max=p50)
    behind = page_of(run(cells)).behind("200 (100–300)")
    assert behind
    assert behind[0] == "E2/lan/stock/0: 100 ms; E2/lan/stock/1: 200 ms; E2/lan/stock/2: 300 ms"


def test_every_number_in_a_table_leads_to_a_cell_or_the_thesis() -> None:
    """No table cell with a digit is without something behind it."""
    for text, title in Page(_whole_page()).cells:
        if re.search(r"\d", text):
            assert title, text


def test_the_appendix_has_every_cell() -> None:
    """Each cell is listed with its key, its status and where in the JSON it is."""
    whole = _everything()
    page = Page(_whole_page())
    for index, result in enumerate(whole.cells):
        assert f"cell-{index}" in page.ids
        assert f"cells[{index}]" in page.words
        assert result.cell.key in page.words


@pytest.mark.parametrize("status", ["failed", "not run"])
def test_a_failed_cell_shows_its_sentence(status: str) -> None:
    """In its table a cell without figures says what became of it, and why."""
    page = page_of(run([failed(a_cell(), "The camera was on fire.", status)]))
    assert page.behind(f"{status}: The camera was on fire.")


def test_a_repetition_that_failed_does_not_hide_the_others() -> None:
    """The figure of those that are ok is shown, with the sentence of the one that failed."""
    page = page_of(run([measured(a_cell()), failed(a_cell(repeat=1), "The link broke.")]))
    assert {*page.behind("failed once: The link broke.")} == {"E2/lan/stock/1: The link broke."}
    assert any("E2/lan/stock/1: failed, The link broke." in title for _, title in page.cells)


def test_why_something_is_missing_is_told_once() -> None:
    """Cells that were not run for one reason are one line at the head of the page."""
    cells = [failed(a_cell(profile=name), "No Go here.", "not run") for name in ("lan", "campus")]
    assert "stock aiortc, 2 cells not run: No Go here." in page_of(run(cells)).words


def test_nothing_measured_is_a_dash() -> None:
    """Where a cell is ok and a figure is None, a dash stands, and no zero."""
    page = page_of(run([bare(a_cell())]))
    behind = page.behind("–")
    assert "E2/lan/stock/0: nothing measured" in behind
    assert not page.behind("0")
    assert not page.behind("none")


def test_the_face_has_no_tone_to_have_gaps() -> None:
    """That no gap was found where no tone is, is not told as "none"."""
    page = page_of(run([measured(a_cell("E4", content="face", browser="firefox"))]))
    assert not page.behind("none")


def test_what_a_run_says_is_escaped() -> None:
    """No text of a run becomes markup, wherever it is shown."""
    evil = "<script>alert(1)</script>&\"'"
    result = measured(
        a_cell(profile=evil), limits=[evil], told={evil: evil, "changes_began_ms": evil}
    )
    whole = run(
        [result, failed(a_cell("E6", evil), evil)],
        machine={evil: evil, "nested": {evil: [evil]}},
        instrument={evil: 1.0},
        arguments=[evil],
        started_utc=evil,
    )
    text = html(whole)
    assert "<script" not in text
    assert "alert(1)" in text
    assert Page(text).tags.isdisjoint({"script"})


def test_recovery_is_counted_from_the_last_change() -> None:
    """An outage from 5 to 7 s after which pictures come at 7.4 s took 0.4 s to recover from."""
    page = Page(_whole_page())
    assert any("E6/outage/operator/25s/0: 400 ms" in title for _, title in page.cells)


def test_limits_of_a_browser_are_named() -> None:
    """E4 says what a browser does not expose."""
    assert "Firefox: Firefox hides the concealment." in Page(_whole_page()).words


def test_the_same_run_gives_the_same_page() -> None:
    """Nothing in the page depends on when it was made."""
    assert html(_everything()) == _whole_page()


_FLOATS = st.floats(width=32) | st.sampled_from([0.0, -1.0, 1e300, math.inf, math.nan])
_LISTS = st.lists(_FLOATS, max_size=4)
_NAMES = st.sampled_from(["lan", "outage", "modem-56k", "", "no such", "$x_{$ & <b>", "\N{BELL}ű"])
_QUANTILES = st.none() | st.builds(
    Quantiles, n=st.integers(0, 9), min=_FLOATS, p50=_FLOATS, p95=_FLOATS, max=_FLOATS
)
_PAUSES = st.builds(Pauses, at_ms=_LISTS, length_ms=_LISTS)
_CELLS = st.builds(
    Cell,
    experiment=st.sampled_from(["E1", "E2", "E4", "E5", "E6"]),
    profile=_NAMES,
    system=st.sampled_from(["thesis", "operator", "stock"]),
    audio_mu_ms=st.sampled_from([None, 100, 500, 7]),
    content=st.sampled_from(["testcard", "face"]),
    browser=st.sampled_from(["chromium", "firefox"]),
    viewers=st.sampled_from([1, 8]),
)
_RESULTS = st.builds(
    CellResult,
    cell=_CELLS,
    status=st.sampled_from(["ok", "ok", "ok", "failed", "not run"]),
    problem=st.none() | _NAMES,
    started_utc=_NAMES,
    took_s=_FLOATS,
    figures=st.none()
    | st.builds(
        Figures,
        from_ms=_FLOATS,
        to_ms=_FLOATS,
        picture_age_ms=_QUANTILES,
        sound_age_ms=_QUANTILES,
        skew_ms=_QUANTILES,
        pictures_per_s=st.none() | _FLOATS,
        tone_pauses=_PAUSES,
        concealed_share=st.none() | _FLOATS,
    ),
    readings=st.none()
    | st.builds(
        Readings,
        opened_ms=_FLOATS,
        pictures=st.builds(
            Pictures, at_ms=_LISTS, stamp_ms=st.lists(st.none() | _FLOATS, max_size=4)
        ),
        sound=st.builds(Sound, start_ms=_LISTS, tone=_LISTS, burst=_LISTS),
    ),
    told=st.dictionaries(st.just("changes_began_ms"), _FLOATS | _NAMES, max_size=1),
)


@given(cells=st.lists(_RESULTS, max_size=4), took_s=_FLOATS, said=_NAMES)
@settings(
    max_examples=20,
    deadline=None,
    # A page takes too long for thousands of tries at a smaller example.
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
def test_any_run_has_a_page(cells: list[CellResult], took_s: float, said: str) -> None:
    """Whatever `Run` allows, columns of different lengths and no numbers included, is shown."""
    page = page_of(run(cells, took_s=took_s, started_utc=said, machine={said: took_s}))
    assert len([one for one in page.ids if one.startswith("cell-")]) == len(cells)
