"""The documents: links resolve, and the first page stays short."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parents[1]
_LINK: Final = re.compile(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"")
_BLOCK: Final = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
_CODE: Final = re.compile(r"`[^`\n]*`")
_FILE: Final = re.compile(r"`([\w./-]+\.(?:py|tsx?|cpp|json))`")
_CONSTANT: Final = re.compile(r"`(_?[A-Z]+(?:_[A-Z]+)*)`")
_EXCERPT: Final = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
_MOST_LINES: Final = 250
_MOST_BYTES: Final = 16_000
FILES: Final = sorted(
    subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    .stdout.rstrip("\0")
    .split("\0")
)
TEXTS: Final = [name for name in FILES if name.endswith(".md")]
CONCEPTS: Final = [
    f"server/wax/{name}"
    for name in ("control/README.md", "control/TURNS.md", "sync/README.md", "congestion/README.md")
]


def _anchors(text: str) -> set[str]:
    """Return the anchors that GitHub derives from the headings."""
    headings = re.findall(r"^#+ (.+)$", _BLOCK.sub("", text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", TEXTS)
def test_links_lead_somewhere(name: str) -> None:
    """Every linked file exists, and has the linked heading."""
    path = ROOT / name
    prose = _CODE.sub("", _BLOCK.sub("", path.read_text(encoding="utf-8")))
    for found in _LINK.finditer(prose):
        link = found[1] or found[2]
        if "://" in link:
            continue
        target, _, anchor = link.partition("#")
        there = (path.parent / target).resolve() if target else path
        assert there.exists(), f"{name}: {link}"
        if anchor:
            assert anchor in _anchors(there.read_text(encoding="utf-8")), f"{name}: {link}"


def _found(name: str) -> list[str]:
    return [one for one in FILES if f"/{one}".endswith(f"/{name}")]


@pytest.mark.parametrize("name", ["server/README.md", ".github/CONTRIBUTING.md", *CONCEPTS])
def test_the_guides_name_files_and_constants_that_exist(name: str) -> None:
    """Files that are named without a link can be found, and constants in those files."""
    for part in re.split(r"\n\n|\n(?=\|)", (ROOT / name).read_text(encoding="utf-8")):
        files = {named: _found(named) for named in _FILE.findall(part)}
        assert [named for named, found in files.items() if not found] == []
        text = "".join((ROOT / one).read_text("utf-8") for found in files.values() for one in found)
        assert [one for one in _CONSTANT.findall(part) if one not in text] == []


@pytest.mark.parametrize("name", CONCEPTS)
def test_a_concept_is_a_short_page_that_draws_and_quotes(name: str) -> None:
    """A page of a concept has 120 lines at most, a drawing, and lines that a file it links has."""
    path = ROOT / name
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    assert "```mermaid\n" in text
    linked = [path.parent / found[1] for found in _LINK.finditer(text) if found[1].endswith(".py")]
    sources = [_undented(one.read_text(encoding="utf-8")) for one in linked]
    excerpts = _EXCERPT.findall(text)
    assert excerpts
    for excerpt in excerpts:
        assert any(_undented(excerpt) in source for source in sources), excerpt


def _undented(text: str) -> str:
    return "\n".join(line.strip() for line in text.strip().splitlines())


def test_the_readme_is_read_in_five_minutes() -> None:
    """The README stays short enough for five minutes."""
    data = (ROOT / "README.md").read_bytes()
    assert len(data.splitlines()) <= _MOST_LINES
    assert len(data) <= _MOST_BYTES
