"""Connections fit into the limit of open files, which is raised to the maximum."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from wax.commands.doctor import machine
from wax.config.settings import Settings
from wax.web import descriptors


@pytest.mark.parametrize(
    ("limit", "tree", "expected"),
    [
        (None, {}, 640),
        (20_000, {}, 640),
        (1024, {}, 496),
        (1024, {"network": {"mode": "full-ice"}}, 16),
        (1024, {"server": {"max_viewers": 10}}, 640),
        (64, {}, 16),
    ],
)
def test_how_many_fit(limit: int | None, tree: dict[str, object], expected: int) -> None:
    """The sockets of all viewers come first, but a few connections always fit."""
    assert descriptors.connections_that_fit(Settings.model_validate(tree), limit) == expected


@pytest.mark.parametrize(("most", "level"), [(1024, "warning"), (4096, "ok")])
def test_the_doctor_checks_the_limit(most: int, level: str) -> None:
    """It says whether the configured connections fit into this user's limit."""
    verdict = machine.open_files(Settings(), most)
    assert verdict.level == level
    assert str(most) in verdict.sentence


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such limit")
def test_the_limit_is_raised_where_it_is_called_infinite(monkeypatch: pytest.MonkeyPatch) -> None:
    """On macOS it is 256 and cannot be infinite, which left 16 connections for everybody."""
    resource: Any = vars(descriptors)["resource"]
    infinity = resource.RLIM_INFINITY
    now = [(256, infinity)]

    def refuse(_: int, limits: tuple[int, int]) -> None:
        if limits[0] == infinity:
            raise ValueError("current limit exceeds maximum limit")
        now[0] = limits

    monkeypatch.setattr(resource, "getrlimit", lambda _: now[0])
    monkeypatch.setattr(resource, "setrlimit", refuse)
    descriptors.raise_limit()
    assert descriptors.connections_that_fit(Settings(), descriptors.limit()) == 640
    assert now == [(10_240, infinity)]


@pytest.mark.system
@pytest.mark.skipif(sys.platform == "win32", reason="there is no such limit")
def test_the_limit_is_raised() -> None:
    """It rises from a shell's default to the user's maximum."""
    program = (
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (100, 300))\n"
        "from wax.web import descriptors; descriptors.raise_limit(); print(descriptors.limit())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "300"
