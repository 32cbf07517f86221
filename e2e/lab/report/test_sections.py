"""What the sections say of a run: the thesis beside it, the verdicts, and what they leave out."""

from __future__ import annotations

from typing import Any

from e2e.lab.figures import Pauses, Quantiles
from e2e.lab.report.page import html
from e2e.lab.report.reader import Page, a_cell, page_of
from e2e.lab.report.synthetic import START_MS, failed, measured, run


def test_the_thesis_stands_beside_ours() -> None:
    """E1 has the thesis's words, with section and figure behind them, and the model's row."""
    row = {"scene": "LAN", "mu_ms": 100, "pauses_per_s": 2.0, "longest_ms": 216.0, "silence": 0.25}
    whole = run([])
    whole.client2004 = [row, {"something": "else"}]
    page = page_of(whole)
    assert page.behind("1–4 per ½ s, up to 800 ms") == ["thesis 5.2.1.2, Figure 5.20"]
    assert page.behind("2.0 per s")
    assert page.behind("in all 25 %")


def test_the_summary_is_of_this_run() -> None:
    """It says where the policy has pauses and the thesis none, and says the opposite of another."""

    def of(*pauses: tuple[float, float]) -> str:
        cell = a_cell("E1", "lan", "thesis", audio_mu_ms=300)
        return page_of(run([measured(cell, pauses=pauses)])).words

    assert "Pauses where the thesis has none: lan at 300 ms" in of((1.0, 200.0), (4.0, 200.0))
    assert "agrees with it in 1 on" in of()
    assert "Pauses where the thesis has none" not in of()


def test_a_gap_that_2004_bridged_is_no_pause() -> None:
    """A gap of 40 ms stands in the table, but is no pause in the verdict; one of 60 ms is."""

    def of(length_ms: float) -> Page:
        cell = a_cell("E1", "lan", "thesis", audio_mu_ms=300)
        result = measured(cell, pauses=[(4.0, length_ms)])
        assert result.figures is not None
        result.figures.concealed_pauses = Pauses()
        return page_of(run([result]))

    bridged, heard = of(40.0), of(60.0)
    assert bridged.behind("longest 40 ms")
    assert "Pauses where the thesis has none" not in bridged.words
    assert "in the 15 s that were judged of each cell, not one" in bridged.words
    assert "Pauses where the thesis has none: lan at 300 ms" in heard.words


def test_pauses_are_a_share_of_the_time_that_sound_was_judged() -> None:
    """Two gaps in the 6 s that were left of 15 are 20 a minute; in no time there is no figure."""
    late = measured(a_cell(), pauses=[(10.0, 200.0), (12.0, 100.0)])
    assert late.figures is not None
    late.figures.sound_from_ms = late.figures.to_ms - 6000
    page = page_of(run([late]))
    assert page.behind("20 per min")
    assert page.behind("in all 5 %")
    late.figures.tone_pauses = late.figures.concealed_pauses = Pauses()
    assert page_of(run([late])).behind("none")
    late.figures.sound_from_ms = late.figures.to_ms + 1000
    assert not page_of(run([late])).behind("none")


def test_a_link_that_changes_has_its_pauses_too() -> None:
    """What E1 measured on it stands in E1, not the longer cell of E6."""
    cells = [
        measured(a_cell("E1", "step-down", "thesis", audio_mu_ms=200)),
        measured(a_cell("E6", "step-down", "thesis", audio_mu_ms=500, seconds=30.0)),
    ]
    e1 = html(run(cells)).partition('<section id="e1">')[2].partition("</section>")[0]
    assert "E1/step-down/thesis/200ms/0: " in e1
    assert "E6/step-down" not in e1


def test_others_stand_beside_the_thesis_policy() -> None:
    """Who has no MU to choose has one value across all lengths, with tone gaps and concealments."""
    cells = [
        measured(a_cell("E1", "lan", "thesis", audio_mu_ms=100)),
        measured(a_cell("E2", "lan", "livekit"), pauses=[(2.0, 90.0)]),
        failed(a_cell("E2", "lan", "stock"), "The camera was on fire."),
    ]
    e1 = html(run(cells)).partition('<section id="e1">')[2].partition("</section>")[0]
    row = e1.partition(">LiveKit</th>")[2].partition("</tr>")[0]
    assert 'colspan="5"' in row
    assert Page(row).behind("tone gaps: 4 per min")
    assert Page(row).behind("concealments: 4 per min")
    row = e1.partition(">stock aiortc</th>")[2].partition("</tr>")[0]
    assert Page(row).behind("failed: The camera was on fire.")
    assert ">audio-master</th>" not in e1


def test_what_tcp_repaired_in_2004_is_told() -> None:
    """Where a lossy link was measured E1 and the summary say that the baseline is worse off."""

    def of(profile: str) -> str:
        return page_of(run([measured(a_cell("E1", profile, "thesis", audio_mu_ms=500))])).words

    assert of("wifi-bad").count("Where packets are lost (wifi-bad) the baseline") == 2
    assert "Where packets are lost" not in of("internet-5m")


def test_where_the_model_is_not_the_thesis_is_told() -> None:
    """A cell that differs and a figure that does not come out stand in E1, and are counted."""

    def row(scene: str, mu_ms: int, pauses_per_s: float, longest_ms: float) -> dict[str, Any]:
        return {
            "scene": scene,
            "mu_ms": mu_ms,
            "pauses_per_s": pauses_per_s,
            "longest_ms": longest_ms,
            "silence": 0.3,
        }

    whole = run([])
    whole.client2004 = [row("campus", 100, 2.0, 500), row("campus", 200, 1.9, 700)]
    whole.client2004 += [row("LAN", 300, 1.0, 200)]
    page = page_of(whole)
    assert page.behind("1.0 per s, up to 200 ms") == ["client2004, LAN, 300 ms"]
    assert page.behind("with 100 ms 2.0 per s, up to 500 ms; with 200 ms 1.9 per s, up to 700 ms")
    assert "in 2 of 3 connections" in page.words
    assert "it does not reproduce what is said of Figure 5.33." in page.words
    whole.client2004[1]["pauses_per_s"] = 1.0
    assert "Figure 5.33" not in page_of(whole).words


def test_systems_that_are_alike_are_not_ranked() -> None:
    """Medians 4 ms apart share the first place; what is clearly later comes next."""
    cells = []
    for system, p50 in (("stock", 64.0), ("operator", 60.0), ("livekit", 90.0)):
        result = measured(a_cell(system=system))
        assert result.figures is not None
        result.figures.picture_age_ms = Quantiles(n=9, min=p50, p50=p50, p95=p50, max=p50)
        cells.append(result)
    words = page_of(run(cells)).words
    assert "operator and stock aiortc alike on lan (60 to 64 ms, then LiveKit 90)" in words


def test_a_starved_crowd_is_seen() -> None:
    """E5 shows what the other viewers received, and says the least in the summary."""
    told: dict[str, float | str] = {
        "crowd.pictures_per_s_mean": 11.0,
        "crowd.pictures_per_s_min": 4.0,
        "crowd.lost_share": 0.25,
    }
    page = page_of(run([measured(a_cell("E5")), measured(a_cell("E5", viewers=8), told=told)]))
    assert page.behind("least 4")
    assert page.behind("25")
    assert "stock aiortc with 8 viewers 4 pictures a second, 25 % of the packets" in page.words


def test_fail_safe_time_of_older_runs_is_said_to_be_of_another_time() -> None:
    """Where the server's total was kept, E3 says that it begins with the page; else nothing."""
    told: dict[str, float | str] = {"viewer.streams.fail_safe_s": 3.0}
    cell = a_cell("E3", "modem-56k", "thesis", audio_mu_ms=500)
    said = "from when the page was opened"
    assert said in page_of(run([measured(cell, told=told)])).words
    assert said not in page_of(run([measured(cell, told=told | {"counted_from_ms": 1.0})])).words


def test_the_emulators_error_stands_beside_the_instruments() -> None:
    """Figures that are off name their profile; without any the page says how to have them."""
    figure = {"name": "delay_ms", "promised": 20.0, "measured": 26.5, "allowed": 1.0, "ok": False}
    rows = [{"profile": "lan", "ok": False, "figures": {"down": [figure]}}, {"other": 1}]
    page = page_of(run([], emulator=rows))
    assert "0 of 1 figures of 1 profile are" in page.words
    assert "Not so on lan" in page.words
    assert page.behind("26.5") == ["lan, down, delay_ms"]
    assert "python -m e2e.lab.link verify" in page_of(run([])).words


def test_the_command_to_repeat_names_no_folder() -> None:
    """Where the results went on that machine is of no use on another."""
    page = page_of(run([], arguments=["--repeat", "3", "--out", "/some/where"]))
    assert "make lab ARGS='--repeat 3'" in page.words
    assert "/some/where" not in page.words


def test_a_cell_measured_for_another_experiment_is_found() -> None:
    """What E1 measured with 500 ms stands in E2's table; one viewer stands beside the crowd."""
    cells = [
        measured(a_cell("E1", "same-machine", "thesis", audio_mu_ms=500)),
        measured(a_cell("E3", "same-machine", "operator")),
        measured(a_cell("E5", "same-machine", "operator", viewers=8)),
    ]
    text = html(run(cells))
    e2 = text.partition('<section id="e2">')[2].partition("</section>")[0]
    e5 = text.partition('<section id="e5">')[2].partition("</section>")[0]
    assert "E1/same-machine/thesis/500ms/0" in e2
    assert "operator, 1 viewer<" in e5
    assert "operator, 8 viewers<" in e5


def test_recovery_that_does_not_come_is_told() -> None:
    """Where the picture stays old to the end, no number stands, and no dash."""
    stuck = measured(
        a_cell("E6", "outage", seconds=25.0),
        grows_from_s=5.0,
        grows_until_s=99.0,
        told={"changes_began_ms": START_MS + 3000.0},
    )
    assert page_of(run([stuck])).behind("not reached")
