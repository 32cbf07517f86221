"""How many cores the process may use."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from wax.machine import cores

if TYPE_CHECKING:
    from pathlib import Path

V2 = "0::/system.slice/wax.service\n"
V1 = "4:cpu,cpuacct:/docker/1f\n3:memory:/docker/1f\n0::/\n"


@pytest.mark.parametrize(
    ("own", "files", "usable"),
    [
        (V2, {}, 8),
        (V2, {"system.slice/wax.service/cpu.max": "max 100000\n"}, 8),
        (V2, {"system.slice/wax.service/cpu.max": "150000 100000\n"}, 1.5),
        (V2, {"system.slice/cpu.max": "50000 100000\n"}, 0.5),
        ("0::/\n", {"cpu.max": "200000 100000\n"}, 2),
        ("0::/../elsewhere\n", {"cpu.max": "200000 100000\n"}, 2),
        ("0::/\n", {"cpu.max": "6400000 100000\n"}, 8),
        ("0::/\n", {"cpu.max": "0 100000\n"}, 8),
        ("0::/\n", {"cpu.max": "\n"}, 8),
        ("nonsense\n", {"cpu.max": "200000 100000\n"}, 8),
        ("", {"cpu.max": "200000 100000\n"}, 8),
        (V1, {"cpu/cpu.cfs_quota_us": "-1\n", "cpu/cpu.cfs_period_us": "100000\n"}, 8),
        (V1, {"cpu/cpu.cfs_quota_us": "300000\n", "cpu/cpu.cfs_period_us": "100000\n"}, 3),
    ],
)
def test_quotas_count(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    own: str,
    files: dict[str, str],
    usable: float,
) -> None:
    """The least of the affinity and all quotas of our cgroup and those above it counts."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "own").write_text(own)
    assert cores.usable(tmp_path, tmp_path / "own") == usable


@pytest.mark.parametrize(("known", "usable"), [(4, 4), (None, 1)])
def test_without_affinity_and_groups_the_machine_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, known: int | None, usable: int
) -> None:
    """Without affinity and cgroups, as on macOS, the machine's cores count."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: known)
    assert cores.usable(tmp_path, tmp_path / "own") == usable
