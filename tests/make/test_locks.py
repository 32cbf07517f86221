"""The locked versions: complete, hashed, and matching pyproject.toml."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
RUN, DEV, NODE, UV = "requirements.lock", "requirements-dev.lock", ".make/node.lock", ".make/uv.txt"


def _locked(name: str) -> dict[str, set[str]]:
    """Return versions by package; there are two where platforms differ."""
    versions: dict[str, set[str]] = {}
    for line in (ROOT / name).read_text(encoding="utf-8").splitlines():
        pin = re.match(r"([A-Za-z0-9._-]+)==(\S+)", line)
        if pin:
            versions.setdefault(canonicalize_name(pin[1]), set()).add(pin[2])
    return versions


@pytest.mark.parametrize("name", [RUN, DEV, NODE, UV])
def test_every_version_has_hashes_and_no_host(name: str) -> None:
    """The locked files are installed, from whichever mirror they come."""
    text = (ROOT / name).read_text(encoding="utf-8")
    pin = r"^[A-Za-z0-9._-]+==[^\n]*\n(?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)*"
    pins = re.findall(pin, text, re.MULTILINE)
    assert pins
    assert all("--hash" in pin for pin in pins)
    assert "://" not in text
    rest = re.sub(r"#.*\n", "", text)
    assert rest == "".join(pins)


def test_lock_of_run_is_part_of_the_lock_of_test() -> None:
    """`make run` after `make test` has nothing to change."""
    dev = _locked(DEV)
    assert all(dev[name] == versions for name, versions in _locked(RUN).items())


def test_locks_are_what_the_project_asks_for() -> None:
    """Whoever changes a dependency is told to type `make lock`."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    groups = project["dependency-groups"]
    wanted = {
        RUN: project["project"]["dependencies"] + groups["build"],
        DEV: project["project"]["dependencies"] + groups["build"] + groups["dev"],
        NODE: groups["node"],
        UV: groups["uv"],
    }
    for name, lines in wanted.items():
        locked = _locked(name)
        for requirement in map(Requirement, lines):
            versions = locked.get(canonicalize_name(requirement.name), set())
            assert versions, f"{name} lacks {requirement}: type make lock"
            assert all(map(requirement.specifier.contains, versions)), f"{requirement}: make lock"


def test_page_lock_holds_every_platform() -> None:
    """`npm ci` works on macOS too, and refuses a lock without the packages of other platforms."""
    packages = json.loads((ROOT / "web/package-lock.json").read_text(encoding="utf-8"))["packages"]
    names = {path.rpartition("node_modules/")[2] for path in packages}
    missing = {
        f"{path.rpartition('node_modules/')[2]} → {optional}"
        for path, package in packages.items()
        for optional in package.get("optionalDependencies", {})
        if optional not in names
    }
    assert not missing
