"""`python -m tests.ablation`: halves and doubles each constant, on simulated links.

It prints a table and writes it to e2e/out/ablation/table.md; `--json` prints everything. Results of
the same code are reused from e2e/out. With `--trace` it measures recorded traces in mahimahi's
format instead, and changes no constant.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from e2e.measure.suite import ROOT
from tests.ablation import traffic
from tests.ablation.sweep import FACTORS, base, default_jobs, effect, mean, spread, sweep, tuned

if TYPE_CHECKING:
    from tests.ablation.constants import Constant
    from tests.ablation.sweep import Result

_OUT = ROOT / "e2e/out/ablation/results.jsonl"
_MEASURES = ("use", "picture_ms", "sound_ms", "concealed", "recovery_s")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.ablation", description=__doc__)
    parser.add_argument("--jobs", type=int, default=default_jobs(), help="processes at a time")
    parser.add_argument("--json", action="store_true", help="print all that was measured")
    parser.add_argument("--trace", type=Path, nargs="+", help="traces, or folders of them")
    parser.add_argument("--traffic", action="store_true", help="measure cross traffic alone")
    arguments = parser.parse_args()
    if arguments.trace:
        print(json.dumps(traffic.over_traces(arguments.trace), indent=1))
        return 0
    if arguments.traffic:
        print(json.dumps(traffic.cross_traffic(), indent=1))
        return 0
    found = sweep(_OUT, arguments.jobs)
    rows = [_row(one, found) for one in tuned()]
    if arguments.json:
        print(json.dumps({"links": base(found), "rows": rows, "traffic": traffic.cross_traffic()}))
        return 0
    table = _table(rows)
    print(table)
    (_OUT.parent / "table.md").write_text(table + "\n", encoding="utf-8")
    return 0


def phrases(constant: Constant, found: dict[str, Result]) -> dict[str, str]:
    """Return in words what halving and doubling a constant change most."""
    chance = spread(found)
    before = base(found)
    return {name: effect(before, found[f"{constant.key} {name}"], chance) for name in FACTORS}


def _row(constant: Constant, found: dict[str, Result]) -> dict[str, Any]:
    values = {
        f"{measure} {name}": mean(found[f"{constant.key} {name}"], measure)
        for name in FACTORS
        for measure in _MEASURES
    }
    return {"key": constant.key, "value": constant.value, "values": values} | phrases(
        constant, found
    )


def _table(rows: list[dict[str, Any]]) -> str:
    head = "| constant | value | half | double |\n| --- | ---: | --- | --- |"
    lines = [
        f"| `{row['key']}` | {_number(row['value'])} | {row['half']} | {row['double']} |"
        for row in rows
    ]
    return "\n".join([head, *lines])


def _number(value: object) -> str:
    return ", ".join(f"{one:g}" for one in (value if isinstance(value, tuple) else (value,)))


if __name__ == "__main__":
    raise SystemExit(main())
