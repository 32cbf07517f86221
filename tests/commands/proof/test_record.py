"""The record: all findings in plain words."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser

import pytest

from wax.commands.proof.measure import Sample
from wax.commands.proof.record import RecordHeading, page, sentence
from wax.commands.proof.verdict import FAULTS, Finding, Findings
from wax.config.settings import parse

SETTINGS = parse({"robot": {"driver": "serial", "serial": {"url": "/dev/<robot>"}}}, "the test")
HEADING = RecordHeading("2026-11-21 22:40 UTC", "lab <1>, Linux", "0.5")
GOOD = Sample(frame_ms=161.0, standing_ms=251.0, speed_mps=0.18)
LATE = Sample(frame_ms=900.0, standing_ms=990.0, speed_mps=0.18)


def findings(*samples: Sample, skip: str | None = None, broken: str | None = None) -> Findings:
    found = [
        Finding(fault, skipped="there is none.")
        if fault.key == skip
        else Finding(fault, samples or (GOOD, GOOD))
        for fault in FAULTS
    ]
    return Findings(tuple(found), 2, reports=True, braking_mps2=2.0, broken=broken)


class Reader(HTMLParser):
    """Collects tags and text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.attributes: set[str] = set()
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_it_says_in_one_sentence_what_came_out() -> None:
    """One sentence says how often links were cut and how fast the robot stopped."""
    assert str(sentence(findings())) == (
        "Every link was cut 2 times; the robot stood within 251 ms, its own braking included."
    )


def test_it_names_what_was_too_late() -> None:
    """A failed proof names the link, and does not say that the robot stopped in time."""
    assert str(sentence(findings(GOOD, LATE))).startswith(
        "Not proved: too late, or no stop at all: "
    )
    assert str(FAULTS[0].title) in str(sentence(findings(GOOD, LATE)))
    assert str(sentence(findings(broken="it was aborted."))) == "Not proved: it was aborted."


def test_it_does_not_claim_what_was_not_measured() -> None:
    """A link that was not cut is named with the reason, and not marked as passed."""
    some = findings(skip="cut")
    assert str(sentence(some)) == (
        "Each measurable link was cut 2 times; the robot stood within 251 ms,"
        " its own braking included. Not proved: The serial line is cut."
    )
    html = page(some, SETTINGS, HEADING)
    assert 'class="verdict passed"' in page(findings(), SETTINGS, HEADING)
    assert 'class="verdict partly"' in html
    assert 'class="verdict failed"' in page(findings(GOOD, LATE), SETTINGS, HEADING)
    text = Reader(html).text
    assert "cut: there is none." in text
    assert "not proved" in text
    assert "Not proved" not in page(findings(), SETTINGS, HEADING)


def test_a_stop_that_was_seen_in_the_drivers_process_is_no_frame() -> None:
    """Without a tap, the record names the driver, and says where the stop was observed."""
    seen = replace(findings(), sees="driver")
    text = Reader(page(seen, SETTINGS, HEADING)).text
    assert "stop called, ms" in text
    assert "stop frame, ms" not in text
    assert "the call of the driver's stop" in text
    assert "Driver serial" in text
    assert "/dev/<robot>" not in text


def test_the_page_stands_alone() -> None:
    """The page is valid HTML without scripts, images or links, and escapes the configuration."""
    html = page(findings(), SETTINGS, HEADING)
    read = Reader(html)
    assert read.open == []
    assert not read.tags & {"script", "img", "link", "iframe", "robot", "1"}
    assert not read.attributes & {"src", "href", "onclick", "onload"}
    assert "/dev/<robot>" in read.text
    assert "lab <1>" in read.text


@pytest.mark.parametrize(
    "needed",
    [
        *(str(fault.title) for fault in FAULTS),
        "no emergency stop and no certified safety function",
        "Signature",
        "0.6 m/s",
        "200 ms after the newest frame",
        "150 ms plus",
        "340",
        "250 ms plus the time to brake",
        "2026-11-21",
    ],
)
def test_it_tells_what_a_person_must_know(needed: str) -> None:
    """Each link, what it is not, who signs, limits and times of the configuration, and the date."""
    assert needed in Reader(page(findings(), SETTINGS, HEADING)).text


def test_a_robot_that_moves_sideways_was_also_driven_so() -> None:
    """The record says in which directions it was driven, and how fast it may be sideways."""
    sideways = SETTINGS.model_copy(
        update={"robot": SETTINGS.robot.model_copy(update={"max_lateral_mps": 0.4})}
    )
    text = Reader(page(findings(), sideways, HEADING)).text
    assert "driven forward and sideways in turn at slow speed" in text
    assert "At most 0.6 m/s, 0.4 m/s sideways and 1.5 rad/s" in text
    assert "sideways" not in page(findings(), SETTINGS, HEADING)


def test_rows_tell_failures_apart() -> None:
    """Late and unfinished rows are marked, and a missing time is not a number."""
    never = Sample(frame_ms=None, standing_ms=None, speed_mps=0.18)
    text = Reader(page(findings(GOOD, never), SETTINGS, HEADING)).text
    assert "1 × never" in text
    assert "FAILED" in text
    assert "NOT FINISHED" in Reader(page(findings(GOOD), SETTINGS, HEADING)).text


def test_braking_that_is_worse_than_configured_is_advised() -> None:
    """If the configured braking exceeds the measured one, the record says what to set."""
    slow = Sample(frame_ms=100.0, standing_ms=280.0, speed_mps=0.18)
    assert "set robot.braking_mps2" in page(findings(slow, slow), SETTINGS, HEADING)
    assert "set robot.braking_mps2" not in page(findings(), SETTINGS, HEADING)
