"""How many of the machine's cores this process may use."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

_GROUPS: Final = Path("/sys/fs/cgroup")
_OWN: Final = Path("/proc/self/cgroup")


def usable(groups: Path = _GROUPS, own: Path = _OWN) -> float:
    """Return the cores by affinity (`taskset`, a container's cpuset) or quota, whichever is less.

    Neither `os.cpu_count` nor the affinity knows quotas (Docker's ``--cpus``, systemd's
    ``CPUQuota=``), which may be a fraction of a core.
    """
    affinity = getattr(os, "sched_getaffinity", None)
    allowed = len(affinity(0)) if affinity else os.cpu_count() or 1
    return min([float(allowed), *_quotas(groups, own)])


def _quotas(groups: Path, own: Path) -> Iterator[float]:
    """Yield the quotas of our cgroup and of all above it: cgroups(7), both versions."""
    for line in _words(own, separator="\n"):
        _, controllers, path = line.split(":", 2) if line.count(":") >= 2 else ("", "?", "")
        if controllers and "cpu" not in controllers.split(","):
            continue
        root = groups / "cpu" if controllers else groups
        inner = Path(path.lstrip("/"))
        # In a container, the path may be the host's, of which only the root is visible.
        for folder in {root, *(root / part for part in (inner, *inner.parents))}:
            limit = _words(folder / "cpu.max") or [
                *_words(folder / "cpu.cfs_quota_us"),
                *_words(folder / "cpu.cfs_period_us"),
            ]
            if len(limit) == 2 and all(one.isdecimal() and int(one) for one in limit):
                yield int(limit[0]) / int(limit[1])


def _words(path: Path, separator: str | None = None) -> list[str]:
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip().split(separator)
    except OSError:
        return []
