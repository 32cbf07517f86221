"""``python -m e2e.lab.link verify [PROFILE…]``: JSON on standard output, a table beside it.

Exit status: 0 when every figure is within what is allowed; 1 when one is not; 2 when there is no
link or no such profile.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tests.link.errors import LinkError
from tests.link.profile import load, names

from e2e.lab.link.verify import verify

if TYPE_CHECKING:
    from e2e.lab.link.verify import Verified


def main() -> int:
    arguments = _arguments()
    try:
        return asyncio.run(_verify(arguments.profiles or names()))
    except LinkError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


async def _verify(profiles: list[str]) -> int:
    for name in profiles:
        load(name)  # a wrong name is told before the others take their time
    found = []
    for name in profiles:
        verified = await verify(name)
        found.append(verified)
        print(_table(verified), file=sys.stderr, flush=True)
    print(json.dumps([_json(verified) for verified in found], indent=1))
    return 0 if all(verified.ok for verified in found) else 1


def _json(verified: Verified) -> dict[str, Any]:
    tree = asdict(verified)
    tree["ok"] = verified.ok
    for way, figures in verified.figures.items():
        for row, figure in zip(tree["figures"][way], figures, strict=True):
            row["ok"] = figure.ok
    return tree


def _table(verified: Verified) -> str:
    lines = [f"{verified.profile} ({verified.took_s:.1f} s)"]
    for way, figures in verified.figures.items():
        lines += [
            f"  {way:4} {figure.name:20} promised {figure.promised:12.4g}"
            f"  measured {figure.measured:12.4g}  ± {figure.allowed:9.3g}"
            f"  {'ok' if figure.ok else 'NOT OK'}"
            for figure in figures
        ]
    lines += [f"  {note}" for note in verified.notes]
    used = verified.statistics
    late_ms = max(used.down_late.worst_ms, used.up_late.worst_ms)
    lines.append(
        f"  mover: {used.cpu_s / used.running_s:.0%} of a core, latest packet {late_ms:.1f} ms late"
    )
    return "\n".join(lines)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m e2e.lab.link", description=__doc__)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("verify", help="measure the link against its profiles")
    command.add_argument("profiles", nargs="*", metavar="PROFILE", help="all, when none is named")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
