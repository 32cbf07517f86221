"""The record of a proof: one self-contained page of HTML that prints on A4."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Final

from wax.commands.proof.verdict import FRAME_LIMIT_MS, ROBOT_LIMIT_MS, spread
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from wax.commands.proof.verdict import Finding, Findings, StopSpread
    from wax.commands.proof.watch import Sees
    from wax.config.robot import RobotSettings
    from wax.config.settings import Settings

_STYLE: Final = """
@page { size: A4; margin: 12mm 15mm }
body { font: 8.5pt/1.3 system-ui, sans-serif; color: #111; max-width: 180mm; margin: 8mm auto }
@media print { body { margin: 0 } }
h1 { font-size: 16pt; margin: 0 0 2mm }
h2 { font-size: 10.5pt; margin: 4mm 0 1mm }
p { margin: 1mm 0 }
.verdict { font-size: 12pt; padding: 3mm; border: 0.6mm solid; margin: 3mm 0 }
.passed { border-color: #1a7f37 }
.partly { border-color: #9a6700 }
.failed { border-color: #b3261e }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: bottom; padding: 0.8mm 1.5mm }
th { font-weight: 600 }
td { border-top: 0.2mm solid #999; vertical-align: top }
.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums }
ul { margin: 0; padding-left: 5mm }
.sign { display: flex; gap: 8mm; margin-top: 14mm }
.sign span { flex: 1; border-top: 0.2mm solid #111; padding-top: 1mm }
"""

_STOP: Final[dict[Sees, str]] = {"line": "stop frame, ms", "driver": "stop called, ms"}
_MEASURED: Final[dict[Sees, str]] = {
    "line": "A tap on the serial line measured the time from the cut to the stop frame",
    "driver": "In the driver's process the time was measured from the cut to the call of the"
    " driver's stop, not to what it then sent,",
}

_NOT_MEASURED: Final = (
    "The delay of the Internet: the operator was on this machine. The page shows operators the"
    " delay of their link.",
    "The picture: there was none, and the robot drove at slow speed. Testing the rules for late"
    " pictures needs a camera.",
    "The weight of the robot on the floor: wheels in the air stop sooner.",
)
_ABOUT: Final = 0.9
"""Allows for the few milliseconds that the report itself takes."""


@dataclass(frozen=True, slots=True)
class RecordHeading:
    """When and where the proof was made, for people to read."""

    date: str
    machine: str
    version: str


def page(findings: Findings, settings: Settings, heading: RecordHeading) -> str:
    """Return the whole page."""
    verdict = "failed"
    if findings.all_passed:
        verdict = "partly" if findings.skipped else "passed"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Proof of the stop, {escape(heading.date)}</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>Proof of the stop</h1>
<p>{escape(heading.date)} · {escape(heading.machine)} · WAX {escape(heading.version)}</p>
<p class="verdict {verdict}">{escape(str(sentence(findings)))}</p>
{_table(findings)}
<h2>How it was measured</h2>
<p>{escape(_method(findings, settings.robot))}</p>
{_not_proved(findings)}<h2>Not measured</h2>
{_list(_NOT_MEASURED)}
<h2>The robot's configuration</h2>
{_list(_configuration(findings, settings))}
<h2>What this is not</h2>
<p>This stop is software. It is no emergency stop and no certified safety function: where people
may be hurt, a switch in the robot's power line that everybody near can reach is needed too. The
record holds for this installation as it was configured on this day.</p>
<p class="sign"><span>Place, date</span><span>Name</span><span>Signature</span></p>
</body>
</html>
"""


def sentence(findings: Findings) -> Sentence:
    """Return the verdict in one sentence."""
    if findings.broken is not None:
        return Sentence("proof.broken", {"why": findings.broken})
    if not findings.all_passed:
        late = _titles([one for one in findings.measured if not findings.passed(one)])
        return Sentence("proof.late", {"which": late or Sentence("proof.nothing")})
    skipped = _titles(findings.skipped)
    passed = Sentence(
        "proof.passed",
        {
            "every": Sentence("proof.every" if skipped is None else "proof.measurable"),
            "latest": Sentence(
                "proof.stood" if findings.reports else "proof.told",
                {"ms": _number(findings.latest_ms)},
            ),
            "n": findings.repeats,
        },
    )
    if skipped is None:
        return passed
    return Sentence("proof.passed_but", {"passed": passed, "skipped": skipped})


def _titles(findings: Sequence[Finding]) -> Sentence | None:
    """Return what was cut, as a list in words; None for nothing."""
    titles = [finding.fault.title for finding in findings]
    if not titles:
        return None
    *firsts, listed = titles
    for first in reversed(firsts):
        listed = Sentence("proof.list", {"first": first, "rest": listed})
    return listed


def _table(findings: Findings) -> str:
    groups = [("", 2), (_STOP[findings.sees], 3)]
    heads = ["median", "max", "limit"]
    if findings.reports:
        groups.append(("standing still, ms", 4))
        heads += ["median", "max", "limit", "braking"]
    spans = "".join(f'<th class="number" colspan="{wide}">{name}</th>' for name, wide in groups)
    names = "".join(f'<th class="number">{name}</th>' for name in ("n", *heads))
    above = f"<tr>{spans}<th></th></tr>\n<tr><th>Link</th>{names}<th>Result</th></tr>"
    rows = "\n".join(_row(findings, one) for one in findings.findings)
    return f"<table>\n{above}\n{rows}\n</table>"


def _row(findings: Findings, finding: Finding) -> str:
    cells = [str(len(finding.samples)), *_frame_cells(finding)]
    if findings.reports:
        cells += _standing_cells(findings, finding)
    if finding.skipped is not None:
        result = "not proved"
    elif len(finding.samples) < findings.repeats:
        result = "NOT FINISHED"
    else:
        result = "passed" if findings.passed(finding) else "FAILED"
    numbers = "".join(f'<td class="number">{escape(cell)}</td>' for cell in cells)
    return f"<tr><td>{escape(str(finding.fault.title))}</td>{numbers}<td>{result}</td></tr>"


def _frame_cells(finding: Finding) -> list[str]:
    if finding.fault.ends == "robot" or not finding.samples:
        return ["–", "–", "–"]
    frames = spread(sample.frame_ms for sample in finding.samples)
    return [_number(frames.median_ms), _max(frames), _number(FRAME_LIMIT_MS)]


def _standing_cells(findings: Findings, finding: Finding) -> list[str]:
    if not finding.samples:
        return ["–", "–", "–", "–"]
    standing = spread(sample.standing_ms for sample in finding.samples)
    limit_ms = min(findings.standing_limit_ms(sample.speed_mps) for sample in finding.samples)
    braking = "–"
    if finding.fault.ends == "frame":
        braking = _max(spread(sample.braking_ms for sample in finding.samples))
    return [_number(standing.median_ms), _max(standing), _number(limit_ms), braking]


def _method(findings: Findings, robot: RobotSettings) -> str:
    ways = "forward and sideways in turn" if robot.lateral_mps > 0 else "forward"
    method = (
        f"Wheels off the floor, the robot was driven {ways} at slow speed by an operator on"
        " this machine, and each link was cut n times, at random moments."
        f" {_MEASURED[findings.sees]} after which no motion was requested"
    )
    if not findings.reports:
        return f"{method}. The robot does not report when it stands."
    return (
        f"{method}, and to the robot's own report after which it reported no motion. The limit for"
        f" standing still is {ROBOT_LIMIT_MS:g} ms plus the time to brake from its speed at the"
        f" configured {findings.braking_mps2:g} m/s². If no server is left to stop the robot, its"
        " own watchdog must."
    )


def _not_proved(findings: Findings) -> str:
    """Return the part about the links that were not cut, empty if there are none."""
    if not findings.skipped:
        return ""
    lines = [f"{finding.fault.title}: {finding.skipped}" for finding in findings.skipped]
    return f"<h2>Not proved</h2>\n{_list(lines)}\n"


def _configuration(findings: Findings, settings: Settings) -> list[str]:
    robot, drive = settings.robot, settings.drive
    serial = robot.serial
    sideways = f", {robot.lateral_mps:g} m/s sideways" if robot.lateral_mps else ""
    line = f"Serial line {serial.url}, {serial.baud} bit/s, dialect {serial.dialect}"
    lines = [
        line if findings.sees == "line" else f"Driver {robot.driver}",
        f"At most {robot.max_linear_mps:g} m/s{sideways} and {robot.max_angular_rps:g} rad/s,"
        f" accelerating at no more than {robot.max_linear_acceleration_mps2:g} m/s² and"
        f" {robot.max_angular_acceleration_rps2:g} rad/s²; slow speed is {drive.slow_fraction:g}"
        " of that",
        f"A command counts for {drive.max_age_ms:g} ms plus the link's own delay, at most"
        f" {drive.max_command_age_ms:g} ms",
        f"The driver process stops the robot after {robot.silence_ms} ms of silence",
    ]
    if findings.sees == "line" and serial.dialect == "frames":
        lines.append(f"The robot stops by itself {serial.ttl_ms} ms after the newest frame")
    return [*lines, _braking(findings)]


def _braking(findings: Findings) -> str:
    configured = f"Braking as configured: {findings.braking_mps2:g} m/s²"
    measured = findings.measured_braking_mps2
    if measured is None:
        return configured
    is_less = measured < findings.braking_mps2 * _ABOUT
    advice = "; set robot.braking_mps2 to that or less" if is_less else ""
    return f"{configured}; measured, including the report's delay: {measured:.2g} m/s²{advice}"


def _list(lines: Iterable[str]) -> str:
    return "<ul>\n" + "\n".join(f"<li>{escape(line)}</li>" for line in lines) + "\n</ul>"


def _max(times: StopSpread) -> str:
    return f"{times.missing} × never" if times.missing else _number(times.max_ms)


def _number(time_ms: float | None) -> str:
    return "–" if time_ms is None else f"{time_ms:.0f}"
