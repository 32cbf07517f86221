"""Profiles: the shipped ones can be used, and each wrong key gets one sentence."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest
from tests.link.errors import ProfileError
from tests.link.profile import FOLDER, Profile, load, names, parse

if TYPE_CHECKING:
    from pathlib import Path

PROMISED = {
    "same-machine lan campus internet-5m wireless-2m wireless-1m modem-56k dual-modem isdn-64k",
    "lte-good lte-edge wifi-bad satellite step-down",
}


def table(**down: Any) -> dict[str, Any]:
    plain = {"rate_bps": 1_000_000, "queue_ms": 500, "delay_ms": 20}
    return {"about": "a test", "down": {**plain, **down}, "up": plain}


def problem(**down: Any) -> str:
    with pytest.raises(ProfileError) as told:
        parse(table(**down), "x.toml")
    return str(told.value)


def test_every_promised_profile_is_shipped() -> None:
    """Each network of the thesis and of today that we promise can be loaded."""
    assert set(" ".join(PROMISED).split()) <= set(names())
    for name in names():
        assert load(name).about


@pytest.mark.parametrize("name", names())
def test_each_profile_states_its_queue(name: str) -> None:
    """No shipped direction leaves its queue to a default; modems hold 1.5 or 2 s, others 500 ms."""
    text = (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    queue_ms = 1500 if name in {"modem-56k", "dual-modem", "isdn-64k"} else 500
    queue_ms = 2000 if name == "modem-28k" else queue_ms
    stated = [int(value) for value in re.findall(r"^queue_ms = (\d+)", text, re.MULTILINE)]
    assert stated == [queue_ms, queue_ms]


def test_stated_figures_are_those_asked_for() -> None:
    """The modem, the satellite and poor Wi-Fi have the figures that were promised."""
    modem, satellite, wifi = load("modem-56k"), load("satellite"), load("wifi-bad")
    assert (modem.down.rate_bps, modem.up.rate_bps) == (50_000, 33_000)
    assert modem.down.jitter is not None
    assert (modem.down.delay_ms, modem.down.jitter.ms) == (60, 10)
    assert (satellite.down.delay_ms, satellite.up.delay_ms) == (300, 300)
    assert wifi.down.loss.mean == pytest.approx(0.05, rel=0.001)
    rates = [conditions.rate_bps for _, conditions in load("step-down").down.steps()]
    assert rates == [5_000_000, 300_000, 5_000_000]


def test_an_unknown_profile_is_one_sentence() -> None:
    """For a wrong name the sentence has the nearest name and all names."""
    with pytest.raises(ProfileError, match=r"^there is no profile campsu; did you mean campus\?"):
        load("campsu")


def test_an_unknown_key_is_one_sentence() -> None:
    """A wrong key is named with its table and the nearest right one."""
    assert problem(delai_ms=3) == (
        "x.toml: down.delai_ms: there is no such key; did you mean delay_ms?"
    )


def test_a_wrong_value_is_told_with_what_is_allowed() -> None:
    """One sentence has the given value and the allowed ones, even inside a nested table."""
    told = problem(jitter={"distribution": "gauss", "ms": 3})
    assert told.startswith('x.toml: down.jitter.distribution: got "gauss"; allowed is "uniform"')
    assert "down.rate_bps: got 5; allowed is a whole number from" in problem(rate_bps=5)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"queue_bytes": 5}, "either queue_ms or queue_bytes"),
        ({"trace": "a.trace"}, "exclude each other"),
        ({"jitter": {"distribution": "normal", "ms": 10}}, "up to 30 ms from a delay of 20 ms"),
        ({"jitter": {"distribution": "uniform", "ms": 1, "shape": 3}}, "belong to pareto only"),
        ({"stalls": {"every_s": 1, "at_least_ms": 9, "at_most_ms": 3}}, "exchange them"),
        ({"outage": True}, "outage belongs into a change"),
        ({"changes": [{"at_s": 2, "outage": True}]}, "last change is an outage"),
        ({"changes": [{"at_s": 2}, {"at_s": 2}]}, "not in the order of at_s"),
        (
            {"changes": [{"at_s": 2, "jitter": {"distribution": "uniform", "ms": 30}}]},
            "the change at 2 s: jitter takes up to 30 ms",
        ),
    ],
)
def test_what_contradicts_itself_is_told(wrong: dict[str, Any], said: str) -> None:
    """Keys that are valid alone but not together are refused with what to do."""
    told = problem(**wrong)
    assert said in told
    assert "\n" not in told


def test_changes_build_on_each_other() -> None:
    """A change keeps what it does not mention, and either kind of queue replaces the other."""
    changes = [{"at_s": 1, "rate_bps": 2_000}, {"at_s": 2, "queue_bytes": 9}]
    steps = parse(table(changes=changes), "x.toml").down.steps()
    assert [at_s for at_s, _ in steps] == [0, 1, 2]
    last = steps[-1][1]
    assert (last.rate_bps, last.queue_ms, last.queue_bytes, last.delay_ms) == (2_000, None, 9, 20)


@pytest.mark.parametrize("name", names())
def test_a_profile_survives_the_way_to_the_forwarder(name: str) -> None:
    """Written as JSON and read again it is the same profile."""
    profile = load(name)
    assert Profile.model_validate_json(profile.model_dump_json(exclude_unset=True)) == profile


def test_a_trace_is_found_beside_its_profile(tmp_path: Path) -> None:
    """A trace is named relative to its profile, and a bad or missing one is reported at once."""
    way = '[{0}]\ntrace = "there.trace"\nqueue_ms = 500\n'
    path = tmp_path / "mine.toml"
    path.write_text('about = "mine"\n' + way.format("down") + way.format("up"))
    with pytest.raises(ProfileError, match=r"there\.trace: cannot be read"):
        load(str(path))
    (tmp_path / "there.trace").write_text("5\n3\n")
    with pytest.raises(ProfileError, match="its times must not fall"):
        load(str(path))
    (tmp_path / "there.trace").write_text("1\n5\n")
    assert load(str(path)).down.trace == str(tmp_path / "there.trace")


def test_a_recorded_drive_is_a_pair_of_traces(tmp_path: Path) -> None:
    """NAME.down and NAME.up are a link with a queue; without an uplink there is one sentence."""
    (tmp_path / "town.down").write_text("1\n5\n")
    with pytest.raises(ProfileError, match=r"town\.up: cannot be read"):
        load(str(tmp_path / "town.down"))
    (tmp_path / "town.up").write_text("2\n9\n")
    drive = load(str(tmp_path / "town.down"))
    assert drive.about == "recorded while driving: town"
    assert (drive.down.queue_ms, drive.up.delay_ms) == (600, 30)
    assert (drive.down.trace, drive.up.trace) == tuple(
        str(tmp_path / f"town.{way}") for way in ("down", "up")
    )
