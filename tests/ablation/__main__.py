"""`python -m tests.ablation`: half and double of each constant, on simulated links.

It prints a table, and with `--json` everything; `--publish` writes e2e/published/ablation.json for
the commit that is checked out, and into the note behind each constant what half and double of it
change. What was measured of the same code is taken again from e2e/out. With `--trace` it measures
recorded traces in the format of mahimahi instead, and changes no constant.
"""

from __future__ import annotations

import argparse
import json
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from e2e.measure import machine
from e2e.measure.published import FOLDER, Published
from e2e.measure.row import Row
from e2e.measure.suite import ROOT, digest
from tests.ablation import traffic
from tests.ablation.constants import constants
from tests.ablation.sweep import FACTORS, MEASURES, default_jobs, effect, mean, spread, sweep, tuned

if TYPE_CHECKING:
    from tests.ablation.constants import Constant
    from tests.ablation.sweep import Result

_OUT = ROOT / "e2e/out/ablation/results.jsonl"
_MEASURES = ("use", "picture_ms", "sound_ms", "concealed", "recovery_s")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.ablation", description=__doc__)
    parser.add_argument("--jobs", type=int, default=default_jobs(), help="processes at a time")
    parser.add_argument("--json", action="store_true", help="print all that was measured")
    parser.add_argument(
        "--publish",
        action="store_true",
        help="write e2e/published/ablation.json and the notes behind the constants",
    )
    parser.add_argument("--trace", type=Path, nargs="+", help="traces, or folders of them")
    parser.add_argument("--traffic", action="store_true", help="measure cross traffic alone")
    arguments = parser.parse_args()
    if arguments.trace:
        print(json.dumps(traffic.over_traces(arguments.trace), indent=1))
        return 0
    if arguments.traffic:
        print(json.dumps(traffic.cross_traffic(), indent=1))
        return 0
    if arguments.publish and machine.commit().endswith("-dirty"):
        print("what is not committed is not published; commit it first", file=sys.stderr)
        return 2
    found = sweep(_OUT, arguments.jobs)
    rows = [_row(one, found) for one in tuned()]
    if arguments.json:
        print(
            json.dumps({"links": found["seed 1"], "rows": rows, "traffic": traffic.cross_traffic()})
        )
    else:
        print(_table(rows))
    if arguments.publish:
        print(f"published: {_publish(rows, found['seed 1'])}", file=sys.stderr)
        for one, row in zip(tuned(), rows, strict=True):
            one.write_effect(f"Half: {row['half']}; double: {row['double']}.")
    return 0


def phrases(constant: Constant, found: dict[str, Result]) -> dict[str, str]:
    """Say what half and double of a constant change most."""
    chance = spread(found)
    return {
        name: effect(found["seed 1"], found[f"{constant.key} {name}"], chance) for name in FACTORS
    }


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


def _publish(rows: list[dict[str, Any]], links: Result) -> Path:
    measured = [
        Row(
            key=row["key"],
            what=f"{_number(row['value'])}; half: {row['half']}; double: {row['double']}",
            n=1,
            values={
                name: None if one is None else round(one, 3) for name, one in row["values"].items()
            },
        )
        for row in rows
    ]
    today = [
        Row(
            key=f"link.{link}",
            what=f"as it is, on {link}",
            n=1,
            values=_small(values),
        )
        for link, values in links.items()
    ]
    published = Published(
        suite="ablation",
        commit=machine.commit(),
        date=datetime.now(tz=UTC).date().isoformat(),
        machine="simulation, without a clock",
        load=None,
        measures=list(MEASURES),
        measured=digest(MEASURES),
        columns=[f"{measure} {name}" for measure in _MEASURES for name in FACTORS],
        rows=[*today, *measured],
        notes=[
            "Means over the simulated links that have the measure; the words name the one link and"
            " measure that changes most.",
            f"{len(constants()) - len(tuned())} constants are left out: facts of the wire, and"
            " bounds that no link reaches.",
        ],
    )
    path = FOLDER / "ablation.json"
    FOLDER.mkdir(parents=True, exist_ok=True)
    path.write_text(published.model_dump_json(indent=1, exclude_defaults=True) + "\n")
    return path.relative_to(ROOT)


def _small(values: dict[str, float | None]) -> dict[str, float | None]:
    return {name: None if one is None else round(one, 3) for name, one in values.items()}


if __name__ == "__main__":
    raise SystemExit(main())
