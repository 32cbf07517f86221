"""The page keeps its promises for whatever a run has or lacks."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from html.parser import HTMLParser
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from e2e.lab.cell import Cell
from e2e.lab.figures import Figures, Pauses, Quantiles
from e2e.lab.readings import Pictures, Readings, Sound
from e2e.lab.report import write
from e2e.lab.report.__main__ import main
from e2e.lab.report.page import html
from e2e.lab.report.synthetic import START_MS, bare, failed, measured, run
from e2e.lab.results import CellResult

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.lab.results import Run


class Page(HTMLParser):
    """What a reader has: the ids, the links, and each table cell with what stands behind it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.cells: list[tuple[str, str]] = []
        self.images: list[dict[str, str | None]] = []
        self.words = ""
        self.tags: set[str] = set()
        self._in_td = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.add(tag)
        if (one := given.get("id")) is not None:
            self.ids.append(one)
        if (link := given.get("href")) is not None:
            self.links.append(link)
        if tag == "img":
            self.images.append(given)
        if tag == "td":
            self._in_td = True
        elif self._in_td and tag in ("a", "span"):
            self.cells.append(("", given.get("title") or ""))

    def handle_endtag(self, tag: str) -> None:
        if tag == "td":
            self._in_td = False

    def handle_data(self, data: str) -> None:
        self.words += data
        if self._in_td and self.cells:
            text, title = self.cells[-1]
            self.cells[-1] = (text + data, title)

    def behind(self, text: str) -> list[str]:
        """Give what stands behind each table cell that reads so."""
        return [title for shown, title in self.cells if " ".join(shown.split()) == text]


def _page(of: Run) -> Page:
    return Page(html(of))


def _cell(experiment: str = "E2", profile: str = "lan", system: str = "stock", **more: Any) -> Cell:
    return Cell.model_validate(
        {"experiment": experiment, "profile": profile, "system": system, **more}
    )


def _everything() -> Run:
    cells = [
        measured(
            _cell("E1", "lan", "thesis", audio_mu_ms=mu_ms),
            picture_ms=350,
            sound_ms=mu_ms,
            fps=10,
            pauses=[(1.0, 200.0), (5.0, 90.0)] if mu_ms < 300 else [],
        )
        for mu_ms in (100, 200, 300, 400, 500)
    ]
    cells += [measured(_cell("E2", system="operator", repeat=repeat)) for repeat in (0, 1)]
    cells += [measured(_cell("E2", system="operator", content="face"))]
    cells += [measured(_cell("E3", "modem-56k", "thesis", audio_mu_ms=500), fps=0.5)]
    cells += [failed(_cell("E3", "modem-56k", "livekit"), "The page did not load.")]
    cells += [measured(_cell("E4", browser="firefox"), limits=["Firefox hides the concealment."])]
    cells += [measured(_cell("E5", viewers=viewers)) for viewers in (1, 8)]
    cells += [
        measured(
            _cell("E6", "outage", "operator", seconds=25.0),
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
    page = _page(run([], machine={}, instrument={}))
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
        measured(_cell(repeat=repeat), picture_ms=ms) for repeat, ms in enumerate((100, 200, 300))
    ]
    for result, p50 in zip(cells, (100.0, 200.0, 300.0), strict=True):
        assert result.figures is not None
        result.figures.picture_age_ms = Quantiles(n=9, min=p50, p50=p50, p95=p50, max=p50)
    behind = _page(run(cells)).behind("200 (100–300)")
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
    page = _page(run([failed(_cell(), "The camera was on fire.", status)]))
    assert page.behind(f"{status}: The camera was on fire.")


def test_a_repetition_that_failed_does_not_hide_the_others() -> None:
    """The figure of those that are ok is shown, with the sentence of the one that failed."""
    page = _page(run([measured(_cell()), failed(_cell(repeat=1), "The link broke.")]))
    assert {*page.behind("failed once: The link broke.")} == {"E2/lan/stock/1: The link broke."}
    assert any("E2/lan/stock/1: failed, The link broke." in title for _, title in page.cells)


def test_why_something_is_missing_is_told_once() -> None:
    """Cells that were not run for one reason are one line at the head of the page."""
    cells = [failed(_cell(profile=name), "No Go here.", "not run") for name in ("lan", "campus")]
    assert "stock aiortc, 2 cells not run: No Go here." in _page(run(cells)).words


def test_nothing_measured_is_a_dash() -> None:
    """Where a cell is ok and a figure is None, a dash stands, and no zero."""
    page = _page(run([bare(_cell())]))
    behind = page.behind("–")
    assert "E2/lan/stock/0: nothing measured" in behind
    assert not page.behind("0")
    assert not page.behind("none")


def test_the_face_has_no_tone_to_have_gaps() -> None:
    """That no gap was found where no tone is, is not told as "none"."""
    page = _page(run([measured(_cell("E4", content="face", browser="firefox"))]))
    assert not page.behind("none")


def test_what_a_run_says_is_escaped() -> None:
    """No text of a run becomes markup, wherever it is shown."""
    evil = "<script>alert(1)</script>&\"'"
    result = measured(
        _cell(profile=evil), limits=[evil], told={evil: evil, "changes_began_ms": evil}
    )
    whole = run(
        [result, failed(_cell("E6", evil), evil)],
        machine={evil: evil, "nested": {evil: [evil]}},
        instrument={evil: 1.0},
        arguments=[evil],
        started_utc=evil,
    )
    text = html(whole)
    assert "<script" not in text
    assert "alert(1)" in text
    assert Page(text).tags.isdisjoint({"script"})


def test_the_thesis_stands_beside_ours() -> None:
    """E1 has the thesis's words, with section and figure behind them, and the model's row."""
    row = {"scene": "LAN", "mu_ms": 100, "pauses_per_s": 2.0, "longest_ms": 216.0, "silence": 0.25}
    whole = _everything()
    whole.client2004 = [row, {"something": "else"}]
    page = _page(whole)
    assert page.behind("1–4 per ½ s, up to 800 ms") == ["thesis 5.2.1.2, Figure 5.20"]
    assert page.behind("2.0 per s")
    assert page.behind("in all 25 %")


def test_the_summary_is_of_this_run() -> None:
    """It says where the policy has pauses and the thesis none, and says the opposite of another."""

    def of(*pauses: tuple[float, float]) -> str:
        cell = _cell("E1", "lan", "thesis", audio_mu_ms=300)
        return _page(run([measured(cell, pauses=pauses)])).words

    assert "Pauses where the thesis has none: lan at 300 ms" in of((1.0, 200.0), (4.0, 200.0))
    assert "agrees with it in 1 on" in of()
    assert "Pauses where the thesis has none" not in of()


def test_a_cell_measured_for_another_experiment_is_found() -> None:
    """What E1 measured with 500 ms stands in E2's table; one viewer stands beside the crowd."""
    cells = [
        measured(_cell("E1", "same-machine", "thesis", audio_mu_ms=500)),
        measured(_cell("E3", "same-machine", "operator")),
        measured(_cell("E5", "same-machine", "operator", viewers=8)),
    ]
    text = html(run(cells))
    e2 = text.partition('<section id="e2">')[2].partition("</section>")[0]
    e5 = text.partition('<section id="e5">')[2].partition("</section>")[0]
    assert "E1/same-machine/thesis/500ms/0" in e2
    assert "operator, 1 viewer<" in e5
    assert "operator, 8 viewers<" in e5


def test_recovery_is_counted_from_the_last_change() -> None:
    """An outage from 5 to 7 s after which pictures come at 7.4 s took 0.4 s to recover from."""
    page = Page(_whole_page())
    assert any("E6/outage/operator/25s/0: 400 ms" in title for _, title in page.cells)


def test_recovery_that_does_not_come_is_told() -> None:
    """Where the picture stays old to the end, no number stands, and no dash."""
    stuck = measured(
        _cell("E6", "outage", seconds=25.0),
        grows_from_s=5.0,
        grows_until_s=99.0,
        told={"changes_began_ms": START_MS + 3000.0},
    )
    assert _page(run([stuck])).behind("not reached")


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
    page = _page(run(cells, took_s=took_s, started_utc=said, machine={said: took_s}))
    assert len([one for one in page.ids if one.startswith("cell-")]) == len(cells)


def test_the_command_writes_the_page_beside_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``python -m e2e.lab.report RUN.json`` writes RUN.html and says so."""
    path = tmp_path / "run.json"
    path.write_text(run([measured(_cell())]).model_dump_json(), encoding="utf-8")
    assert main([str(path)]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "run.html")
    write(run([measured(_cell())]), tmp_path / "other.html")
    assert (tmp_path / "run.html").read_bytes() == (tmp_path / "other.html").read_bytes()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "cannot be read"),
        (b"\xff\xfe", "is not JSON"),
        (b"{", "is not JSON"),
        (b"[1]", "is not a run of this lab"),
        (json.dumps({"started_utc": "x"}).encode(), "is not a run of this lab (took_s: "),
    ],
)
def test_what_is_no_run_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes | None, said: str
) -> None:
    """A file that is missing, no JSON, or something else: one line, exit 2, nothing written."""
    path = tmp_path / "run.json"
    if content is not None:
        path.write_bytes(content)
    assert main([str(path), str(tmp_path / "out.html")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out.html").exists()


def test_a_run_is_not_overwritten_by_its_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run whose name ends in .html keeps its content."""
    path = tmp_path / "run.html"
    path.write_text(run([]).model_dump_json(), encoding="utf-8")
    assert main([str(path)]) == 2
    assert "is the run itself" in capsys.readouterr().err
    assert json.loads(path.read_bytes())["cells"] == []


def test_a_page_that_cannot_be_written_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder that is not there: one line and exit 2."""
    path = tmp_path / "run.json"
    path.write_text(run([]).model_dump_json(), encoding="utf-8")
    assert main([str(path), str(tmp_path / "none" / "out.html")]) == 2
    assert "cannot be written" in capsys.readouterr().err
