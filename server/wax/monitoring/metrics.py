"""The metrics for Prometheus, collected at each scrape; nothing is counted for them otherwise.

No label names a person: viewers come and go, and each label value is a time series for ever.
"""

from __future__ import annotations

from collections import Counter
from itertools import accumulate
from statistics import median
from typing import TYPE_CHECKING, Any, Final

from prometheus_client import CollectorRegistry, ProcessCollector, generate_latest
from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
)
from prometheus_client.registry import Collector

from wax.control.loop_timer import BOUNDS_MS
from wax.protocol.robot_report import ROBOT_NUMBERS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from prometheus_client.core import Metric

    from wax.control.loop_timer import Lateness
    from wax.records.records import Records

_ROLES: Final = ("operator", "queued", "observer")
_AGES: Final = {
    "wax_picture_age_seconds": ("Age of the picture that is shown", "report", "picture", "age_ms"),
    "wax_sound_age_seconds": ("Age of the sound that is heard", "report", "sound", "age_ms"),
    "wax_skew_seconds": ("How much older the sound is than its picture", "skew_ms"),
    "wax_round_trip_seconds": ("Round trip of the link", "round_trip_ms"),
}
_NOT_EVENTS: Final = ("control.jitter_p99_ms", "control.latest_ms")


class Metrics(Collector):
    """Collects from the content of the status page and a few counts; call it in the event loop."""

    def __init__(
        self,
        *,
        status: Callable[[], dict[str, Any]],
        refused: Callable[[Mapping[str, float]], Mapping[str, float]],
        stops: Mapping[str, int],
        lateness: Lateness,
        records: Records,
    ) -> None:
        self._status = status
        self._refused = refused
        self._stops = stops
        self._lateness = lateness
        self._records = records
        self._registry = CollectorRegistry()
        self._registry.register(self)
        ProcessCollector(registry=self._registry)

    def text(self) -> bytes:
        """Return all metrics in Prometheus's text format."""
        return generate_latest(self._registry)

    def describe(self) -> Iterable[Metric]:
        """Return nothing: no other collector has these names, and this avoids a second status."""
        return ()

    def collect(self) -> Iterator[Metric]:
        status = self._status()
        yield InfoMetricFamily("wax", "This server", {"version": status["version"]})
        yield from _of_viewers(status["viewers"])
        yield from _of_turns(status, self._stops)
        yield from _of_streams(status["streams"])
        yield from _of_limits(status["limits"])
        if status["cameras"]:
            yield from _of_cameras(status["cameras"])
        yield from self._of_server(status)
        if status["tape"] is not None:
            yield from _of_tape(status["tape"])
        if status["hooks"]:
            yield from _of_hooks(status["hooks"])

    def _of_server(self, status: Mapping[str, Any]) -> Iterator[Metric]:
        refused = self._refused(status["counters"])
        yield _counter("wax_refused", "What was refused", "reason", refused)
        events = {
            name: count
            for name, count in status["counters"].items()
            if name not in refused and name not in _NOT_EVENTS
        }
        yield _counter("wax_events", "What else happened", "event", events)
        yield _histogram(self._lateness)
        yield GaugeMetricFamily("wax_tasks", "Tasks of the event loop", status["tasks"])
        yield from _of_steps(status["steps"])
        yield GaugeMetricFamily(
            "wax_records_waiting", "Records not written yet", self._records.waiting
        )
        yield CounterMetricFamily(
            "wax_records_dropped", "Records lost to a full disk or the like", self._records.dropped
        )


def _of_viewers(viewers: Iterable[Mapping[str, Any]]) -> Iterator[Metric]:
    everybody = list(viewers)
    roles = Counter(dict.fromkeys(_ROLES, 0))
    roles.update(one["role"] for one in everybody)
    found = (_at(one, "streams", "rendition") for one in everybody)
    renditions = Counter(name for name in found if isinstance(name, str))
    yield _gauge("wax_viewers", "Viewers who are connected", "role", roles)
    yield GaugeMetricFamily("wax_queue_length", "Viewers who wait for a turn", roles["queued"])
    yield _gauge("wax_rendition_viewers", "Viewers by rendition", "rendition", renditions)
    groups = {"all": everybody, "operator": [one for one in everybody if one["role"] == "operator"]}
    for name, (what, *path) in _AGES.items():
        family = GaugeMetricFamily(name, f"{what}: median and worst", labels=["who", "of"])
        for who, group in groups.items():
            values = [ms / 1000 for one in group if (ms := _number(_at(one, *path))) is not None]
            if values:
                family.add_metric([who, "median"], median(values))
                family.add_metric([who, "worst"], max(values, key=abs))
        yield family


def _of_turns(status: Mapping[str, Any], stops: Mapping[str, int]) -> Iterator[Metric]:
    yield CounterMetricFamily("wax_turns", "Turns begun", status["turn"]["number"])
    yield _counter("wax_stops", "What stopped the moving robot", "reason", stops)
    latched = status["stop"] is not None
    yield GaugeMetricFamily("wax_stop_latched", "1 while a pressed stop is in force", int(latched))
    robot = status["robot"]
    yield GaugeMetricFamily("wax_robot_connected", "1 if it is", int(bool(robot["connected"])))
    for name, number in ROBOT_NUMBERS.items():
        told = _number(robot.get(name))
        if number.metric is not None and told is not None:
            yield GaugeMetricFamily(*number.metric, told)


def _of_streams(streams: Mapping[str, Any]) -> Iterator[Metric]:
    video, audio = streams["video"], streams["audio"]
    both = {"video": video, "audio": audio}
    up = {name: int(one["problem"] is None) for name, one in both.items()}
    yield _gauge("wax_source_up", "1 if camera or microphone delivers", "stream", up)
    failures = {name: one["failures"] for name, one in both.items()}
    yield _counter("wax_source_failures", "Failures of a source", "stream", failures)
    dropped = {name: one["dropped"] for name, one in both.items()}
    yield _counter("wax_dropped", "Pictures and packets dropped by full lanes", "stream", dropped)
    yield GaugeMetricFamily(
        "wax_captured_pictures_hertz", "Pictures from the camera", video["captured_fps"]
    )
    yield _gauge(
        "wax_encoded_pictures_hertz", "Pictures encoded", "rendition", video["encoded_fps"]
    )
    yield GaugeMetricFamily("wax_captured_sound_hertz", "Blocks of sound", audio["captured_hz"])


def _of_limits(limits: Mapping[str, Any]) -> Iterator[Metric]:
    yield GaugeMetricFamily(
        "wax_sizes_left",
        "The largest sizes of the picture that are not sent, as encoding fell behind",
        len(limits["left"]),
    )
    yield GaugeMetricFamily(
        "wax_observers_limited",
        "1 while observers are sent less, as the event loop is late",
        int(limits["observers_bps"] is not None),
    )


def _of_cameras(cameras: Sequence[Mapping[str, Any]]) -> Iterator[Metric]:
    up = {one["name"]: int(one["problem"] is None) for one in cameras}
    yield _gauge("wax_camera_up", "1 if a camera beside the driving view delivers", "camera", up)
    failures = {one["name"]: one["failures"] for one in cameras}
    yield _counter("wax_camera_failures", "Failures of such a camera", "camera", failures)
    captured = {one["name"]: one["captured_fps"] for one in cameras}
    yield _gauge("wax_camera_pictures_hertz", "Pictures from such a camera", "camera", captured)


def _of_tape(tape: Mapping[str, Any]) -> Iterator[Metric]:
    running = int(tape["problem"] is None)
    yield GaugeMetricFamily("wax_tape_running", "1 while everything is recorded", running)
    yield GaugeMetricFamily("wax_tape_parts", "Parts of the tape", tape["parts"])
    yield GaugeMetricFamily("wax_tape_bytes", "What they take", tape["parts_bytes"])
    yield GaugeMetricFamily("wax_tape_waiting", "What is not written yet", tape["waiting"])
    yield CounterMetricFamily(
        "wax_tape_left_out", "What a slow or full disk kept off the tape", tape["left_out"]
    )


def _of_hooks(hooks: Sequence[Mapping[str, Any]]) -> Iterator[Metric]:
    waiting = {one["name"]: one["waiting"] for one in hooks}
    yield _gauge("wax_hook_waiting", "Events that a hook has not taken yet", "hook", waiting)
    lost = {one["name"]: one["lost"] for one in hooks}
    refused = {one["name"]: one["refused"] for one in hooks}
    yield _counter("wax_hook_refused", "Events that a hook refused for good", "hook", refused)
    off = {one["name"]: int(one["disabled"]) for one in hooks}
    yield _gauge("wax_hook_disabled", "1 if a hook is gone and asked no more", "hook", off)
    yield _counter("wax_hook_lost", "Events that a hook never took", "hook", lost)


def _of_steps(steps: Mapping[str, Mapping[str, float]]) -> Iterator[Metric]:
    counts = {part: one["count"] for part, one in steps.items()}
    yield _counter("wax_long_steps", "Steps of the event loop above 2 ms", "part", counts)
    longest_s = {part: one["longest_ms"] / 1000 for part, one in steps.items()}
    yield _gauge("wax_longest_step_seconds", "The longest since the start", "part", longest_s)


def _histogram(lateness: Lateness) -> Metric:
    names = [*(f"{bound / 1000:g}" for bound in BOUNDS_MS), "+Inf"]
    buckets = list(zip(names, accumulate(lateness.counts), strict=True))
    family = HistogramMetricFamily(
        "wax_loop_lateness_seconds", "How late the control loop's ticks are"
    )
    family.add_metric([], buckets, lateness.sum_s)
    return family


def _counter(name: str, what: str, label: str, values: Mapping[str, float]) -> Metric:
    family = CounterMetricFamily(name, what, labels=[label])
    for key, value in values.items():
        family.add_metric([key], value)
    return family


def _gauge(name: str, what: str, label: str, values: Mapping[str, float]) -> Metric:
    family = GaugeMetricFamily(name, what, labels=[label])
    for key, value in values.items():
        family.add_metric([key], value)
    return family


def _at(tree: object, *path: str) -> object:
    """Follow a path into the status; None where a viewer has no such value."""
    for name in path:
        tree = tree.get(name) if isinstance(tree, dict) else None
    return tree


def _number(value: object) -> float | None:
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None
