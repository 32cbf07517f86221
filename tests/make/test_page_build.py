"""When the page is built again, and with which Node."""

from __future__ import annotations

import gzip
import os
import time
from typing import TYPE_CHECKING

import hatch_build
import page
import pytest

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize(
    ("version", "suitable"),
    [
        ("v20.20.2\n", False),
        ("v22.11.0\n", False),
        ("v22.12.0\n", True),
        ("v23.9.0\n", False),
        ("v24.0.0\n", True),
        ("v25.1.0\n", True),
        ("", False),
        ("node: not found\n", False),
    ],
)
def test_node_is_taken_as_vite_takes_it(version: str, suitable: bool) -> None:
    """22.12 or newer with an even major below 24, or anything from 24 on."""
    assert page.is_suitable(version) is suitable


def _source(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_fingerprint_follows_content_and_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A touched file changes nothing; other content, another name or an added file does."""
    monkeypatch.setattr(page, "ROOT", tmp_path)
    first = tmp_path / "main.ts"
    first.write_text("one")
    before = page.fingerprint(iter(_source(tmp_path)))
    first.touch()
    assert page.fingerprint(iter(_source(tmp_path))) == before
    seen = {before}
    first.write_text("two")
    seen.add(page.fingerprint(iter(_source(tmp_path))))
    first.rename(tmp_path / "other.ts")
    seen.add(page.fingerprint(iter(_source(tmp_path))))
    (tmp_path / "more.ts").write_text("")
    seen.add(page.fingerprint(iter(_source(tmp_path))))
    assert len(seen) == 4


def test_only_sources_make_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What npm installed, what was generated and the README's pictures lead to no other build."""
    monkeypatch.setattr(page, "ROOT", tmp_path)
    monkeypatch.setattr(page, "WEB", tmp_path / "web")
    for name in (
        "web/src/main.ts",
        "web/src/generated/x.ts",
        "web/node_modules/a/b.js",
        "web/screenshots/phone.jpg",
    ):
        file = tmp_path / name
        file.parent.mkdir(parents=True)
        file.touch()
    found = [str(path.relative_to(tmp_path)) for path in page.sources()]
    made_from = [
        f"server/wax/{name}"
        for name in (
            "protocol/messages.py",
            "protocol/compact.py",
            "protocol/tape_events.py",
            "sentence.py",
            "sentences.json",
            "web/schema.py",
        )
    ]
    assert found == [*made_from, "web/src/main.ts"]


def test_texts_are_laid_ready_in_gzip(tmp_path: Path) -> None:
    """Each text gets a compressed copy, always the same for the same text; nothing else changes."""
    (tmp_path / "assets").mkdir()
    script, image = tmp_path / "assets" / "a.js", tmp_path / "b.png"
    script.write_text("let x = 1;\n" * 100)
    image.write_bytes(b"1")
    page.compress(tmp_path)
    twin = tmp_path / "assets" / "a.js.gz"
    first = twin.read_bytes()
    assert gzip.decompress(first) == script.read_bytes()
    page.compress(tmp_path)
    assert twin.read_bytes() == first
    assert {path.name for path in tmp_path.rglob("*") if path.is_file()} == {
        "a.js",
        "a.js.gz",
        "b.png",
    }


def _tried(folder: Path) -> int:
    log = folder / "tried"
    return len(log.read_text()) if log.exists() else 0


def _trying(folder: Path, then: str) -> list[str]:
    return ["sh", "-c", f"printf x >>{folder}/tried; {then}"]


@pytest.fixture
def env(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    monkeypatch.setattr(page, "WEB", tmp_path)
    return {"PATH": os.defpath}


def test_a_mirror_that_hangs_is_given_up(
    tmp_path: Path, env: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Each try ends at its limit, the last one with a sentence."""
    began_s = time.monotonic()
    with pytest.raises(page.PageError, match="was not done after 0 s"):
        page.retry(_trying(tmp_path, "exec sleep 30"), env, limit_s=0.2, tries=2)
    assert time.monotonic() - began_s < 10
    assert capsys.readouterr().err.count("trying again") == 1


def test_a_mirror_that_fails_is_asked_again(
    tmp_path: Path, env: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """The second try may succeed; a person is told why it takes longer."""
    page.retry(_trying(tmp_path, f"test $(wc -c <{tmp_path}/tried) = 2"), env)
    assert _tried(tmp_path) == 2
    assert "failed, see above; trying again" in capsys.readouterr().err


def test_after_the_last_try_it_has_failed(tmp_path: Path, env: dict[str, str]) -> None:
    """A mirror that never answers well is an error."""
    with pytest.raises(page.PageError, match="failed"):
        page.retry(_trying(tmp_path, "exit 7"), env, tries=3)
    assert _tried(tmp_path) == 3


def test_who_interrupts_is_obeyed(tmp_path: Path, env: dict[str, str]) -> None:
    """After Ctrl-C nothing is tried again."""
    with pytest.raises(KeyboardInterrupt):
        page.retry(_trying(tmp_path, "exit 130"), env)  # as a shell reports it
    assert _tried(tmp_path) == 1


def test_a_build_that_is_killed_has_failed(tmp_path: Path, env: dict[str, str]) -> None:
    """A machine without enough memory, or without a shell, is no Ctrl-C: a sentence says it."""
    for status in (137, 254):
        with pytest.raises(page.PageError, match="failed, see above"):
            page.run(_trying(tmp_path, f"exit {status}"), env)


def test_pip_shows_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without Node, and without the package that has it, the build ends without a traceback."""
    monkeypatch.setattr(page, "is_built", lambda: False)
    monkeypatch.setattr(page, "has_node", lambda: False)
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    hook = hatch_build.PageHook.__new__(hatch_build.PageHook)
    with pytest.raises(SystemExit, match=r"^wax: the page was not built: Node 22\.12 or newer"):
        hook.initialize("standard", {})
