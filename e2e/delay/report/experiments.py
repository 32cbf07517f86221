"""Chapter 5's experiments as a table: which cells, by what in rows, which figures in columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tests.baseline.client2004 import table as model
from tests.baseline.client2004.scenes import SCENES

from e2e.delay import thesis
from e2e.delay.found import median, on, profiles, systems, where
from e2e.delay.measures import BRIDGED_MS, LATE_MS, MEASURES
from e2e.delay.names import AGE, GIVEN, NARROW, SYSTEMS, loses
from e2e.delay.report import plots
from e2e.delay.series import RECOVERED_MS
from e2e.delay.thesis import Said

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from e2e.delay.cell import Cell
    from e2e.delay.found import Found
    from e2e.delay.report.plots import Drawn, Read

    Cells = Sequence[Found]
    Words = Mapping[str, Mapping[str, Said]]
    """Whose words → the head of a column → what they say there."""

SAME_MS: Final = 5.0
"""The instrument's own error."""
SAME_SHARE: Final = 0.1
"""What one repetition is trusted for where there are no others."""
CLEAN_PER_MIN: Final = 60 * model.CLEAN_PER_S
"""Fewer pauses than one in 20 s count as none, as for the model of 2004's client."""


@dataclass(frozen=True, slots=True)
class Column:
    """Measures under one another, each with what stands before it; of one audio MU where given."""

    head: str
    shows: tuple[tuple[str, str], ...]
    mu_ms: tuple[int | None, ...] = ()

    def cells(self, cells: Cells) -> list[Found]:
        return where(cells, lambda cell: not self.mu_ms or cell.mu_ms in self.mu_ms)


@dataclass(frozen=True, slots=True)
class Experiment:
    """`row` names what a cell's row is called; `words` are the thesis's about a profile."""

    anchor: str
    title: str
    after: str
    """The place in the thesis that it repeats, or why it is here."""
    takes: Callable[[Cells], list[Found]]
    columns: tuple[Column, ...]
    row: Callable[[Cell], str] = lambda cell: SYSTEMS[cell.system]
    words: Callable[[str, Sequence[Column]], Words] = lambda _, __: {}
    notes: tuple[str, ...] = ()
    says: Callable[[Cells], list[str]] = lambda _: []
    """What it comes to, in sentences that are computed."""
    draws: Callable[[Cells, Read], list[Drawn]] = lambda _, __: []


def _columns(*names: str) -> tuple[Column, ...]:
    """Give a column for each measure, or with a plus between them for several."""
    found = []
    for several in names:
        first, *more = several.split("+")
        measure = MEASURES[first]
        shows = ((first, ""), *((name, f"{_part(name)} ") for name in more))
        unit = measure.unit.lstrip("±")
        found.append(Column(f"{measure.label}, {unit}" if unit else measure.label, shows))
    return tuple(found)


def _part(name: str) -> str:
    return MEASURES[name].label.rpartition(", ")[2]


def _compared(cells: Cells, differs: Callable[[Cell], bool]) -> list[Found]:
    """Those that differ, and those of the same system on the same profile that do not."""
    wanted = {(one.cell.profile, one.cell.system) for one in where(cells, differs)}
    return where(
        cells,
        lambda cell: (cell.profile, cell.system) in wanted and cell.mu_ms in {None, 500},
    )


def _intra(cells: Cells) -> list[Found]:
    """Take the thesis policy with any MU, and those who have none to choose."""
    return where(
        cells,
        lambda cell: (
            cell.is_alone
            and (cell.experiment == "E1" or not cell.is_changing)
            and cell.system in ("thesis", "audio-master", "stock", "livekit")
        ),
    )


def _plain(cells: Cells) -> list[Found]:
    return where(cells, lambda cell: cell.is_plain)


def _talking_head(cells: Cells) -> list[Found]:
    return where(cells, lambda cell: cell.content == "talking-head" and cell.browser == "chromium")


def _stress(cells: Cells) -> list[Found]:
    return where(_plain(cells), lambda cell: cell.profile in NARROW)


def _browsers(cells: Cells) -> list[Found]:
    alone = where(cells, lambda cell: cell.viewers == 1 and cell.content == "testcard")
    return _compared(alone, lambda cell: cell.browser != "chromium")


def _fanout(cells: Cells) -> list[Found]:
    here = where(
        cells,
        lambda cell: (
            (cell.browser, cell.content) == ("chromium", "testcard") and not cell.is_changing
        ),
    )
    return _compared(here, lambda cell: cell.viewers > 1)


def _changing(cells: Cells) -> list[Found]:
    """On a link that changes: of each system those that were watched for longest."""
    here = where(
        cells, lambda cell: cell.is_alone and cell.is_changing and cell.mu_ms in {None, 500}
    )
    longest: dict[tuple[str, str], float] = {}
    for one in here:
        key = (one.cell.profile, one.cell.system)
        longest[key] = max(longest.get(key, 0.0), one.cell.seconds)
    return where(here, lambda cell: cell.seconds == longest[cell.profile, cell.system])


def _of_audio(profile: str, columns: Sequence[Column]) -> Words:
    """Give what was heard in 2004, by each client, and what the model of that client hears."""
    found: dict[str, dict[str, Said]] = {}
    for client, by_mu in thesis.AUDIO.get(profile, {}).items():
        label = "thesis 2004" + (f": {client}" if client else "")
        found[label] = {f"{mu_ms} ms": said for mu_ms, said in by_mu.items()}
    for scene in SCENES:
        if scene.profile == profile:
            found[f"model of 2004’s client: {scene.name}"] = {
                f"{mu_ms} ms": Said(model.words(model.hear(scene, mu_ms)), "5.2, as modelled")
                for mu_ms in model.MU_LENGTHS_MS
            }
    return found


def _of_video(profile: str, columns: Sequence[Column]) -> Words:
    """Give the thesis's words by the measure that they are nearest to."""
    known = dict(thesis.VIDEO.get(profile, {}))
    if profile in thesis.PAUSES_AT_500:
        known["tone_pauses_per_min"] = thesis.PAUSES_AT_500[profile]
    if profile in thesis.SYNC:
        known["skew_p50_ms"] = thesis.SYNC[profile]
    words = {
        column.head: known[name] for column in columns if (name := column.shows[0][0]) in known
    }
    return {"thesis 2004": words} if words else {}


def pauses_per_min(cells: Cells) -> float | None:
    """Tone gaps that 2004's client would not bridge, or concealments, whichever are more."""
    both = (median(cells, f"{one}_pauses_per_min") for one in ("heard_tone", "concealed"))
    return max((one for one in both if one is not None), default=None)


def _agreement(cells: Cells) -> list[str]:
    """Say where the policy has pauses and the thesis none, and the other way round."""
    agree, ours_only, theirs_only = 0, [], []
    for profile, clients in thesis.AUDIO.items():
        # Where several clients were tried, the first is the thesis's own measure of the network.
        told = {mu: said for by_mu in reversed(clients.values()) for mu, said in by_mu.items()}
        for mu_ms, said in sorted(told.items()):
            here = where(on(cells, profile, "thesis"), lambda cell, mu=mu_ms: cell.mu_ms == mu)  # type: ignore[misc]  # no type for a default
            ours = pauses_per_min(here)
            if ours is None:
                continue
            if (ours >= CLEAN_PER_MIN) == (not said.none):
                agree += 1
            elif ours >= CLEAN_PER_MIN:
                ours_only.append(f"{profile} at {mu_ms} ms ({ours:.0f} a minute)")
            else:
                theirs_only.append(f"{profile} at {mu_ms} ms ({said.text})")
    total = agree + len(ours_only) + len(theirs_only)
    same, of = model.agreement()
    found = [
        f"The model of 2004’s client agrees with the thesis in {same} of {of} connections and MU "
        f"lengths on whether there are pauses. It differs: {' '.join(model.differences())}"
    ]
    if total:
        found.append(
            f"Of {total} networks and MU lengths that the thesis reports and this run measured, "
            f"the thesis policy agrees with it in {agree} on whether there are pauses (gaps of at "
            f"most {BRIDGED_MS:.0f} ms, which 2004’s client bridged, do not count, and fewer than "
            f"{CLEAN_PER_MIN:.0f} a minute are none)."
        )
    for words, parts in (
        ("Pauses where the thesis has none", ours_only),
        ("No pauses where the thesis has some", theirs_only),
    ):
        if parts:
            found.append(f"{words}: {', '.join(parts)}.")
    lossy = [name for name in profiles(cells) if loses(name)]
    if lossy:
        found.append(
            f"Where packets are lost ({', '.join(lossy)}) the baseline is worse off than 2004’s "
            "WAX would be: TCP sent again what was lost, so that its sound came whole, if late. "
            "The baseline’s sound is RTP, which is not sent again: a lost packet is a gap, and "
            "when it is the last of its MU the sound waits for a second or longer."
        )
    return found


def _limits(cells: Cells) -> list[str]:
    """Hold the thesis policy against the misalignment that the thesis puts a number to."""
    found = []
    for profile, limit_ms in thesis.SYNC_LIMIT_MS.items():
        size_ms = median(on(cells, profile, "thesis"), "absolute_skew_p95_ms")
        if size_ms is not None:
            kept = "keeps" if size_ms <= limit_ms else "does not keep"
            found.append(
                f"The thesis’s misalignment of at most {limit_ms:.0f} ms on {profile} (5.3.2): "
                f"our thesis policy {kept} it (p95 {size_ms:.0f} ms)."
            )
    return found


def _freshest(cells: Cells) -> list[str]:
    """Say whose picture is the freshest where; who cannot be told apart is named together."""
    found = []
    for profile in profiles(cells):
        ages = {
            system: age_ms
            for system in systems(cells)
            if (age_ms := median(on(cells, profile, system), "picture_age_p50_ms")) is not None
        }
        if len(ages) > 1:
            least = min(ages.values())
            first = [
                SYSTEMS[system]
                for system, age_ms in ages.items()
                if age_ms - least <= max(SAME_MS, SAME_SHARE * least)
            ]
            found.append(f"{profile} {' and '.join(first)} ({least:.0f} ms)")
    if not found:
        return []
    return [
        f"The freshest picture, by its median age (within {SAME_MS:.0f} ms or "
        f"{100 * SAME_SHARE:.0f} % nobody is ahead): {'; '.join(found)}."
    ]


def _unexposed(cells: Cells) -> list[str]:
    """Name what each browser does not expose."""
    limits = {(one.cell.browser, limit): None for one in cells for limit in one.limits}
    return [f"{browser.capitalize()}: {limit}" for browser, limit in limits]


def _row_of(what: Callable[[Cell], str]) -> Callable[[Cell], str]:
    return lambda cell: f"{SYSTEMS[cell.system]}, {what(cell)}"


_PAUSES: Final = (
    ("tone_pauses_per_min", "gaps "),
    ("longest_tone_pause_ms", "longest "),
    ("tone_pause_share", "in all "),
    ("concealed_pauses_per_min", "concealed "),
)
_SOUND: Final = (
    "tone_pauses_per_min+longest_tone_pause_ms+tone_pause_share",
    "concealed_pauses_per_min+longest_concealed_pause_ms",
)
EXPERIMENTS: Final = (
    Experiment(
        "e1",
        "E1 · Pauses in the sound, by the length of the audio MU",
        "thesis 5.2, intra-stream synchronisation",
        _intra,
        (
            *(Column(f"{mu_ms} ms", _PAUSES, (mu_ms,)) for mu_ms in model.MU_LENGTHS_MS),
            Column("no MU to choose", _PAUSES, (None,)),
        ),
        words=_of_audio,
        notes=(
            "Gaps of 30 ms or more in the test card’s tone as it was played, a minute, the longest "
            "in ms, all together in % of the time; and how often in a minute the browser says that "
            "it made up 100 ms or more without a break. One may be heard as the other.",
        ),
        says=_agreement,
        draws=plots.over_mu,
    ),
    Experiment(
        "e2",
        "E2 · Sound against picture, on the test card",
        "thesis 5.3, inter-stream synchronisation",
        _plain,
        _columns("skew_p50_ms", "absolute_skew_p95_ms", "picture_age_p50_ms", "sound_age_p50_ms"),
        words=_of_video,
        notes=(
            "Above 0 the sound comes after the picture. People notice sound that is early by 45 ms "
            "or late by 125 ms (ITU-R BT.1359).",
            f"{thesis.SYNC_JAVA_2.text} ({thesis.SYNC_JAVA_2.where})",
        ),
        says=_limits,
        draws=plots.skew_over_time,
    ),
    Experiment(
        "e2-lips",
        "E2 · Voice against lips, on a film of a talking head",
        "thesis 5.3; its judges were people",
        _talking_head,
        _columns("lip_lag_ms", "lip_correlation", "concealed_percent", "pictures_per_s"),
        notes=(
            "Where the opening of the mouth and the loudness of the voice fit best; a low "
            "correlation makes the lag a guess.",
        ),
    ),
    Experiment(
        "e3",
        "E3 · Thin links",
        "thesis 5.4, bandwidth stress test, and 3.5, predictions",
        _stress,
        _columns(
            "pictures_per_s",
            "picture_age_p50_ms+picture_age_p95_ms",
            "late_pictures_per_s",
            "longest_freeze_ms",
            *_SOUND,
            "received_kb_per_s+received_audio_kb_per_s+received_video_kb_per_s",
            "fail_safe_s",
            "picture_drift_ms_per_min",
        ),
        words=_of_video,
        notes=(
            "In 2004 the client timed a picture’s transfer, from asking to having it; here it is "
            "its age. Late: in 2004 a transfer of more than 100 ms, here more than "
            f"{LATE_MS:.0f} ms older than the cell’s youngest picture.",
            f"The thesis’s WAX needs {thesis.LEAST_BANDWIDTH.text} "
            f"({thesis.LEAST_BANDWIDTH.where}).",
        ),
        draws=plots.picture_over_time,
    ),
    Experiment(
        "e4",
        "E4 · Browsers",
        "thesis 5.5, portability and compatibility",
        _browsers,
        _columns(
            "first_picture_ms",
            "picture_age_p50_ms+picture_age_p95_ms",
            "sound_age_p50_ms",
            "skew_p50_ms",
            "pictures_per_s",
            "longest_freeze_ms",
            *_SOUND,
            "command_round_trip_p50_ms",
        ),
        row=_row_of(lambda cell: cell.browser.capitalize()),
        says=_unexposed,
        notes=(
            f"In 2004: {'; '.join(f'{said.text} ({said.where})' for said in thesis.BROWSERS)}.",
        ),
    ),
    Experiment(
        "e5",
        "E5 · Many viewers",
        "thesis 3.2 and 6.2: a slow client never slows another; no numbers there",
        _fanout,
        _columns(
            "server_cpu",
            "server_memory_mib",
            "picture_age_p50_ms+picture_age_p95_ms",
            "sound_age_p50_ms",
            "command_round_trip_p50_ms+command_round_trip_p95_ms",
            "pictures_per_s",
            "crowd_mean+crowd_least",
            "crowd_lost",
        ),
        row=_row_of(lambda cell: f"{cell.viewers} viewer{'s' if cell.viewers > 1 else ''}"),
        notes=(
            "100 % is one core. The crowd is all viewers but the first, who only count what they "
            "receive: the mean of them and the one that received least. LiveKit is not here: its "
            "viewers join through its own client library, and a crowd of those was not built.",
        ),
        draws=plots.over_viewers,
    ),
    Experiment(
        "e6",
        "E6 · A link that changes",
        "not in the thesis: a step of the rate, an outage",
        _changing,
        _columns(
            "picture_adapted_ms",
            "picture_recovered_ms",
            "sound_adapted_ms",
            "sound_recovered_ms",
            "picture_age_p95_ms",
            "longest_freeze_ms",
            *_SOUND,
        ),
        notes=(
            "From the change until the age is, and stays for about a second, at most "
            f"{RECOVERED_MS:.0f} ms above its median before the first change.",
        ),
        draws=plots.picture_over_time,
    ),
    Experiment(
        "systems",
        "All systems side by side",
        "the thesis’s links and those of today; no thesis for the latter",
        _plain,
        _columns(
            "picture_age_p50_ms+picture_age_p95_ms",
            "sound_age_p50_ms",
            "skew_p50_ms+absolute_skew_p95_ms",
            "pictures_per_s",
            "longest_freeze_ms",
            *_SOUND,
            "first_picture_ms",
            "command_round_trip_p50_ms+command_round_trip_p95_ms",
            "received_kb_per_s",
            "sent_kb_per_s",
        ),
        words=_of_video,
        notes=(AGE, *GIVEN),
        says=_freshest,
    ),
)


def named(cells: Iterable[Found], row: Callable[[Cell], str]) -> dict[str, list[Found]]:
    """Put cells into their rows, systems in their order."""
    rows: dict[str, list[Found]] = {}
    order = list(SYSTEMS)
    for one in sorted(
        cells, key=lambda one: (order.index(one.cell.system), one.cell.viewers, one.cell.browser)
    ):
        rows.setdefault(row(one.cell), []).append(one)
    return rows
