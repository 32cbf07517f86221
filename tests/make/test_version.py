"""The version: in one place, and each has its changes told."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

from wax import __version__

ROOT = Path(__file__).parents[2]


def test_there_is_one_version() -> None:
    """The package's own is the installed one, and pyproject.toml states no other."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "version" in project["dynamic"]
    assert version("wax-teleop") == __version__


def test_every_version_has_its_changes() -> None:
    """The changelog begins with what is not released, then this version, falling from there."""
    text = (ROOT / ".github" / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## (\S+)", text, re.MULTILINE)
    assert headings[:2] == ["Unreleased", __version__]
    released = [tuple(map(int, heading.split("."))) for heading in headings[1:]]
    assert released == sorted(released, reverse=True)
