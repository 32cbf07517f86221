"""The page of a run, what is published of it, and what moved from one run to another."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from typing import TYPE_CHECKING, Any

import pytest

from e2e.delay import chapter5, compare
from e2e.delay.cell import Cell
from e2e.delay.plan import full
from e2e.delay.report.page import html, newest
from e2e.delay.test_measures import result
from e2e.instrument.synthetic import readings
from e2e.measure.machine import Machine
from e2e.measure.results import Origin, Result, Results
from e2e.measure.row import Row

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

MACHINE = Machine(
    cpu="An imagined processor",
    cores=2,
    memory_mib=24_000,
    system="Linux",
    python="3.11",
    versions={"aiortc": "1.16.0"},
    chromium="Chromium 150",
)
VALUES = {"picture_age_p50_ms": 60.0, "picture_age_p95_ms": 80.0, "tone_pauses_per_min": 30.0}


class Page(HTMLParser):
    """What a reader has: the ids, the links, and each text of a table with what stands behind."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.images: list[dict[str, str | None]] = []
        self.tags: set[str] = set()
        self.cells: list[tuple[str, str]] = []
        self._in_td = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.add(tag)
        self.ids += [one for name, one in attrs if name == "id" and one]
        self.links += [one for name, one in attrs if name == "href" and one]
        self.images += [given] if tag == "img" else []
        self._in_td = tag == "td" or (self._in_td and tag == "span")
        if self._in_td and tag == "span":
            self.cells.append(("", given.get("title") or ""))

    def handle_endtag(self, tag: str) -> None:
        self._in_td = self._in_td and tag != "td"

    def handle_data(self, data: str) -> None:
        if self._in_td and self.cells:
            text, title = self.cells[-1]
            self.cells[-1] = (text + data, title)

    def behind(self, text: str) -> list[str]:
        return [title for shown, title in self.cells if " ".join(shown.split()) == text]


def cell(experiment: str = "E2", profile: str = "lan", system: str = "stock", **more: Any) -> Cell:
    return Cell.model_validate(
        {"experiment": experiment, "profile": profile, "system": system, **more}
    )


def keep(
    folder: Path,
    of: Cell,
    values: dict[str, float | None] | str,
    commit: str = "abc",
    measured: str = "0",
    **more: Any,
) -> Cell:
    """Store a cell's figures, or the sentence why there are none."""
    origin = Origin(commit=commit, measured=measured, machine=MACHINE)
    given: dict[str, Any] = {"status": "failed", "problem": values}
    if not isinstance(values, str):
        detail = {"cell": of.model_dump(), "limits": ["Firefox hides <it>."]}
        given = {"rows": [Row(key=of.key, what="", n=1, values=values, detail=detail)]}
    Results(folder).add(
        Result(
            case=of.key,
            n=1,
            origin=origin,
            started_utc="2026-11-22T09:00:00+00:00",
            took_s=20.0,
            load_1min=0.5,
            **given | more,
        )
    )
    return of


def with_readings(folder: Path, of: Cell) -> None:
    path = folder / "cells" / of.key.replace("/", "-") / "read.json"
    path.parent.mkdir(parents=True)
    read = result(readings(15), of, told={"changes_began_ms": 1_800_000_001_000.0})
    path.write_text(read.model_dump_json(), encoding="utf-8")


def page(folder: Path, cells: Sequence[Cell]) -> Page:
    return Page(html(folder, cells))


def test_every_experiment_is_there_and_says_what_is_not(tmp_path: Path) -> None:
    """Of the whole plan with nothing measured each section stands, with the thesis's words."""
    text = html(tmp_path, full())
    found = Page(text)
    assert {"e1", "e2", "e2-lips", "e3", "e4", "e5", "e6", "systems"} <= set(found.ids)
    assert {link.removeprefix("#") for link in found.links} <= set(found.ids)
    assert "“almost every 100 ms there is a pause”" in text
    assert "thesis 5.2.1.2, Figure 5.21" in [title for _, title in found.cells]
    assert "model of 2004’s client: LAN" in text
    assert "exposure and transfer" in text
    assert "no cell of this experiment" in html(tmp_path, [])


def test_the_page_is_one_file_without_script(tmp_path: Path) -> None:
    """The page fetches and runs nothing; its plots are inline, with text for screen readers."""
    cells = [
        *(cell("E1", system="thesis", audio_mu_ms=mu_ms) for mu_ms in (100, 500)),
        *(cell("E5", "same-machine", "operator", viewers=viewers) for viewers in (1, 8)),
        cell("E6", "outage", "operator", seconds=30.0),
    ]
    for one in cells:
        keep(tmp_path, one, {**VALUES, "server_cpu": 20.0})
        with_readings(tmp_path, one)
    found = page(tmp_path, cells)
    assert found.tags.isdisjoint({"script", "link", "iframe", "object"})
    captions = [image["alt"] or "" for image in found.images]
    for part in ("audio MU", "viewers", "skew", "picture’s age"):
        assert any(part in caption for caption in captions), part
    assert all((image["src"] or "").startswith("data:image/svg") for image in found.images)


def test_each_figure_names_its_cells(tmp_path: Path) -> None:
    """A median stands with its spread, and behind it the key and number of every repetition."""
    cells = [
        keep(tmp_path, cell(repeat=n), {"skew_p50_ms": ms}) for n, ms in enumerate((10.0, 20, 30))
    ]
    behind = page(tmp_path, cells).behind("+20 (+10…+30)")
    assert "E2/lan/stock/0: +10 ms; E2/lan/stock/1: +20 ms; E2/lan/stock/2: +30 ms" in behind


def test_every_number_in_a_table_has_something_behind_it(tmp_path: Path) -> None:
    """No table cell with a digit is without a cell of the run or a place in the thesis."""
    cells = [keep(tmp_path, one, dict(VALUES)) for one in full(only=["lan", "modem", "outage"])]
    for text, title in page(tmp_path, cells).cells:
        assert title or not re.search(r"\d", text), text


def test_what_failed_shows_its_sentence_and_hides_nothing(tmp_path: Path) -> None:
    """A cell without figures says why, in its place and once above; other repetitions are shown."""
    cells = [
        keep(tmp_path, cell(), dict(VALUES)),
        keep(tmp_path, cell(repeat=1), "The link broke."),
        keep(tmp_path, cell(system="livekit"), "No Go here.", status="not run"),
    ]
    text = html(tmp_path, cells)
    found = Page(text)
    assert "E2/lan/stock/1" in found.behind("failed: The link broke.")
    assert found.behind("not run: No Go here.")
    assert any("E2/lan/stock/0: 60 ms" in title for _, title in found.cells)
    assert "Of 3 cells: 1 ok, 1 failed, 1 not run." in text
    assert text.count("<li>not run: No Go here.") == 1


def test_nothing_measured_is_a_dash_and_never_is_said(tmp_path: Path) -> None:
    """No number stands where there is none; what was never reached says so."""
    one = keep(tmp_path, cell("E6", "outage", seconds=30.0), {"picture_recovered_ms": None})
    found = page(tmp_path, [one])
    assert "E6/outage/stock/30s/0: never" in found.behind("never")
    assert "E6/outage/stock/30s/0: nothing measured" in found.behind("–")
    assert not found.behind("0")


def test_the_newest_product_counts_and_text_is_escaped(tmp_path: Path) -> None:
    """Results of an older product in the same file are left out; no text becomes markup."""
    keep(tmp_path, cell(), {"skew_p50_ms": 10.0}, commit="old", measured="other")
    keep(tmp_path, cell("E4", browser="firefox"), {"skew_p50_ms": 33.0}, commit="<b>new")
    cells = [cell(), cell("E4", browser="firefox")]
    text = html(tmp_path, cells)
    assert "&lt;b&gt;new" in text
    assert "Firefox: Firefox hides &lt;it&gt;." in text
    assert "<b>new" not in text
    assert not Page(text).behind("+10")
    assert html(tmp_path, cells) == text  # nothing in it depends on when it was made


def test_the_summary_is_of_this_run(tmp_path: Path) -> None:
    """It says where the policy has pauses and the thesis none, and who cannot be told apart."""
    cells = [
        keep(
            tmp_path, cell("E1", system="thesis", audio_mu_ms=400), {"heard_tone_pauses_per_min": 9}
        ),
        *(
            keep(tmp_path, cell(system=system), {"picture_age_p50_ms": ms})
            for system, ms in (("operator", 8.0), ("stock", 12.0), ("livekit", 40.0))
        ),
    ]
    text = html(tmp_path, cells)
    assert "Pauses where the thesis has none: lan at 400 ms (9 a minute)." in text
    assert "lan operator and stock aiortc (8 ms)" in text
    assert "Internet, Linux, 300 ms: thesis “once every two seconds”; model none." in text


def test_what_is_published_is_a_median_for_each_system(tmp_path: Path) -> None:
    """A row for each link and figure, a column for each system; crowds and speech are left out."""
    for n, ms in enumerate((10.0, 20.0, 60.0)):
        keep(tmp_path, cell(system="operator", repeat=n), {"picture_age_p50_ms": ms})
    keep(tmp_path, cell(), {"picture_age_p50_ms": 40.0})
    keep(tmp_path, cell(viewers=8), {"picture_age_p50_ms": 99.0})
    keep(tmp_path, cell(content="talking-head"), {"pictures_per_s": 5.0})
    rows = chapter5.derive([row for one in newest(tmp_path) for row in one.rows])
    assert [(row.key, row.n, row.values) for row in rows] == [
        ("lan/picture_age_p50_ms", 3, {"operator": 20.0, "stock aiortc": 40.0})
    ]


@pytest.mark.parametrize(
    ("before", "after", "counts"),
    [
        ((10.0, 30.0), (35.0, 36.0), False),  # within the wider range
        ((10.0, 11.0), (18.0, 19.0), True),
        ((10.0, 10.1), (14.0, 14.1), False),  # less than the instrument tells apart
        ((100.0,), (108.0,), False),  # without repetitions a tenth stands in
        ((100.0,), (112.0,), True),
    ],
)
def test_a_difference_counts_beyond_spread_and_instrument(
    tmp_path: Path, before: tuple[float, ...], after: tuple[float, ...], counts: bool
) -> None:
    """The wider range is the limit, 10 % without one, and 5 ms in any case."""
    for name, values in (("a", before), ("b", after)):
        for n, ms in enumerate(values):
            keep(tmp_path / name, cell(repeat=n), {"picture_age_p50_ms": ms})
    ((moved,), _) = compare.compare(newest(tmp_path / "a"), newest(tmp_path / "b"))
    assert (moved.beyond > 1) is counts


def test_comparing_says_what_only_one_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Variants, figures and machines that differ are named; a file without results is refused."""
    keep(tmp_path / "a", cell(), {"picture_age_p50_ms": 10.0, "sound_age_p50_ms": 80.0})
    keep(tmp_path / "b", cell(), {"picture_age_p50_ms": 90.0})
    keep(tmp_path / "b", cell(system="operator"), {"picture_age_p50_ms": 8.0}, commit="abc")
    files = [str(tmp_path / name / "results.jsonl") for name in ("a", "b")]
    assert compare.main(files) == 0
    said = capsys.readouterr().out
    assert "E2/lan/stock: only A has sound, p50" in said
    assert "only B has E2/lan/operator" in said
    assert "1 of 1 figures that both have moved" in said
    assert compare.main([files[0], str(tmp_path / "none")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
