"""The version is in one place, is in the changelog, and a released one has its figures."""

from __future__ import annotations

import re
import subprocess
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from e2e.measure.published import Published, everything
from e2e.measure.runner import SUITES
from tests.measure.imagined_figures import imagined

from wax import __version__

ROOT = Path(__file__).parents[2]
CHANGELOG = ROOT / ".github" / "CHANGELOG.md"


def test_there_is_one_version() -> None:
    """The package's version is the installed one, and pyproject.toml states no other."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "version" in project["dynamic"]
    assert version("wax-teleop") == __version__


def test_every_version_has_its_changes() -> None:
    """The changelog starts with unreleased changes, then this version, then falling versions."""
    text = CHANGELOG.read_text(encoding="utf-8")
    headings = re.findall(r"^## (\S+)", text, re.MULTILINE)
    assert headings[:2] == ["Unreleased", __version__]
    released = [tuple(map(int, heading.split("."))) for heading in headings[1:]]
    assert released == sorted(released, reverse=True)


def disagreements(tag: str, project: str, told: str, published: list[Published]) -> list[str]:
    """Return what disagrees with the release `tag`; the changelog begins with version `told`."""
    released = tag.removeprefix("v")
    found = [
        f"{what} {said or 'nothing'}, the tag {tag}"
        for what, said in (
            ("the package says", project),
            ("the changelog begins with", told),
            *((f"{one.suite} was measured at", one.version) for one in published),
        )
        if said != released
    ]
    missing = set(SUITES) - {one.suite for one in published}
    found += [f"{suite} is not published" for suite in sorted(missing)]
    changed = [one for one in published if one.is_changed]
    return found + [f"what {one.suite} measures has changed since" for one in changed]


def test_a_release_that_disagrees_is_told() -> None:
    """Version, changelog and each suite's figures are those of the tag."""
    every = [imagined(suite=suite) for suite in SUITES]
    assert disagreements("v1.2.3", "1.2.3", "1.2.3", every) == []
    (said,) = disagreements("v1.2.3", "1.2.2", "1.2.3", every)
    assert said == "the package says 1.2.2, the tag v1.2.3"
    assert len(disagreements("v1.2.3", "1.2.3", "1.2.2", every)) == 1
    for wrong in (
        imagined(suite="stop", version="1.2.2"),
        imagined(suite="stop", measured="other"),
    ):
        rest = [one for one in every if one.suite != "stop"]
        assert len(disagreements("v1.2.3", "1.2.3", "1.2.3", [*rest, wrong])) == 1
        assert disagreements("v1.2.3", "1.2.3", "1.2.3", rest) == ["stop is not published"]


@pytest.mark.full
@pytest.mark.system
def test_a_tagged_release_agrees() -> None:
    """If HEAD is tagged as a version, everything is of that version."""
    listed = ["git", "-C", str(ROOT), "tag", "--points-at", "HEAD", "v[0-9]*"]
    tags = subprocess.run(listed, check=False, capture_output=True, text=True).stdout.split()
    told = re.findall(r"^## (\d\S*)", CHANGELOG.read_text(encoding="utf-8"), re.MULTILINE)[0]
    for tag in tags:
        assert disagreements(tag, __version__, told, everything()) == []
