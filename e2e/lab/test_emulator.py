"""The emulator's own error gets from its packets into the page."""

from __future__ import annotations

import pytest

from e2e.harness.missing import missing
from e2e.lab.emulator import verified
from e2e.lab.link import Link, UnavailableError
from e2e.lab.report.emulator import emulator
from e2e.lab.report.synthetic import run


@pytest.mark.timeout(60)
async def test_a_profile_is_verified_as_the_page_shows_it() -> None:
    """Each figure of a real link is kept with what was promised, in both directions."""
    try:
        async with Link("lan"):
            pass
    except UnavailableError as error:
        missing(str(error))
    found = await verified("lan")
    assert set(found["figures"]) == {"down", "up"}
    shown = emulator(run([], emulator=[found]))
    assert shown is not None
    count = sum(len(figures) for figures in found["figures"].values())
    assert len(shown.table.rows) == 1 + count
    assert f"of {count} figures of 1 profile " in shown.text


async def test_a_link_that_fails_is_told() -> None:
    """What cannot be verified is a row that says why."""
    found = await verified("campsu")
    assert (found["ok"], found["profile"]) == (False, "campsu")
    assert "did you mean campus" in found["problem"]
