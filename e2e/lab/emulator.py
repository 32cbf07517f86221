"""What the emulator makes of a profile, measured with packets, as a run keeps it."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from e2e.lab.link import LinkError
from e2e.lab.link.verify import verify


async def verified(profile: str) -> dict[str, Any]:
    """Verify one profile, some 10 s: each figure as promised and as measured, and what is allowed.

    A link that fails is told as `problem`; the cells will say the same.
    """
    try:
        found = await verify(profile)
    except LinkError as error:
        return {"profile": profile, "ok": False, "problem": str(error)}
    mover = found.statistics
    return {
        "profile": profile,
        "ok": found.ok,
        "took_s": found.took_s,
        "figures": {
            way: [{**asdict(figure), "ok": figure.ok} for figure in figures]
            for way, figures in found.figures.items()
        },
        "notes": found.notes,
        "cpu_share": mover.cpu_s / mover.running_s,
        "latest_ms": max(mover.down_late.worst_ms, mover.up_late.worst_ms),
    }
