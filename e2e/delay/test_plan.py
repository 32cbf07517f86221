"""The plan: everything that is wanted once, in an order that keeps links, within its time."""

from __future__ import annotations

from fnmatch import fnmatchcase
from itertools import chain, pairwise, product

import pytest
from tests.baseline.client2004.table import MU_LENGTHS_MS

from e2e.delay import plan
from e2e.delay.__main__ import main
from e2e.delay.cell import Cell
from e2e.delay.names import CHAPTER5
from e2e.delay.plan import EVERY_SYSTEM, estimate_s, full, matches, quick
from e2e.link import load

HOUR_S = 3600


def measured(cells: list[Cell]) -> set[str]:
    """Name what is measured, whichever experiment it was for."""
    return {cell.variant.partition("/")[2] for cell in cells}


def test_each_profile_with_each_audio_mu_is_there() -> None:
    """E1 has all profiles of chapter 5 but the outage, with sound of 100 to 500 ms."""
    found = {(c.profile, c.audio_mu_ms) for c in full() if c.experiment == "E1"}
    assert found == set(product(set(CHAPTER5) - {"outage"}, MU_LENGTHS_MS))


def test_nothing_is_measured_twice() -> None:
    """A cell that two experiments need is there once, and every key is its own."""
    cells = full(repeats=2)
    assert len({cell.key for cell in cells}) == len(cells)
    assert len(measured(cells)) == len(cells) / 2


@pytest.mark.parametrize(
    "name",
    [
        "same-machine/thesis/500ms/talking-head",
        "internet-5m/livekit",
        "internet-5m/video-first/talking-head",
        "modem-56k/operator",
        "wifi-bad/stock",
        "same-machine/operator",
        "same-machine/thesis/500ms/firefox",
        "internet-5m/stock/firefox",
        "same-machine/operator/16-viewers",
        "same-machine/stock/8-viewers",
        "outage/livekit/30s",
        "step-down/thesis/500ms/30s",
    ],
)
def test_each_experiment_has_its_own(name: str) -> None:
    """Contents, browsers, crowds, changes and peers are all in the full plan."""
    assert name in measured(full())


def test_what_is_trimmed_was_there() -> None:
    """Every pattern of what is left out matches a cell, which is then not in the plan."""
    for pattern in chain.from_iterable(plan.TRIMMED.values()):
        assert [cell for cell in plan.everything() if fnmatchcase(cell.variant, pattern)]
        assert not [cell for cell in full() if fnmatchcase(cell.variant, pattern)]


def test_only_the_hour_is_trimmed_for(capsys: pytest.CaptureFixture[str]) -> None:
    """What is left out of the whole is there with --long, and for whoever asks for it by name."""
    trimmed = "E5/same-machine/stock/16-viewers"
    for words, suffix, expected in (
        (["--n", "3"], "/0", False),
        (["--only", "E5"], "/0", True),
        (["--long"], "/60s/2", True),
    ):
        assert main([*words, "--list"]) == 0
        assert (f"{trimmed}{suffix}" in capsys.readouterr().out.splitlines()) is expected


def test_changes_are_watched_to_their_end() -> None:
    """A cell of E6 goes on well after the last change of its link."""
    for cell in full():
        if cell.experiment == "E6":
            last_s = load(cell.profile).down.steps()[-1][0]
            assert cell.seconds >= max(30, last_s + 10)


def test_links_and_browsers_are_kept_together() -> None:
    """Of each repetition, a profile with one browser comes once, not now and then."""
    stages = [(cell.repeat, cell.profile, cell.browser) for cell in full(repeats=2)]
    changes = [after for before, after in pairwise(stages) if before != after]
    assert len(changes) == len(set(changes))
    assert [repeat for repeat, _, _ in stages] == sorted(repeat for repeat, _, _ in stages)


def test_quick_touches_every_part() -> None:
    """The short run has each system, browser and content, a crowd, a change and a thin link."""
    cells = quick()
    assert {cell.system for cell in cells} == set(EVERY_SYSTEM)
    assert {cell.browser for cell in cells} == {"chromium", "firefox"}
    assert {cell.content for cell in cells} == {"testcard", "talking-head"}
    assert {cell.experiment for cell in cells} == {"E1", "E2", "E3", "E4", "E5", "E6"}
    assert {100, 500} <= {cell.audio_mu_ms for cell in cells}
    assert max(cell.viewers for cell in cells) > 1
    assert any((load(cell.profile).down.rate_bps or 0) <= 1_000_000 for cell in cells)


def test_the_plans_fit_their_time() -> None:
    """Everything once ends within the hour, and the short run within four minutes."""
    assert estimate_s(full()) <= HOUR_S
    assert estimate_s(quick(), own_error=False) <= 4 * 60


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("E1/lan", True),
        ("lan/*/300ms", True),
        ("thesis", True),
        ("E2", False),
        ("lan/300ms", False),
    ],
)
def test_a_pattern_is_part_of_a_name(pattern: str, *, expected: bool) -> None:
    """A pattern matches where it is somewhere in the cell's name, with * for anything."""
    cell = Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=300)
    assert matches(cell, [pattern]) is expected


def test_only_takes_what_any_pattern_matches() -> None:
    """Several patterns add up, and what an experiment shares with an earlier one is in its part."""
    assert measured(full(only=["E2/same-machine/thesis", "E6/outage/stock"])) == {
        "same-machine/thesis/500ms",
        "same-machine/thesis/500ms/talking-head",
        "outage/stock/30s",
    }
