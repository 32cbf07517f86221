"""Fan-out: what each further viewer costs the server's core."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.bench.errors import BenchError
from e2e.bench.plan import FPS
from e2e.bench.process import CoreMeter, two_cores, udp_receive_errors
from e2e.bench.servers import Server
from e2e.crowd import Crowd

if TYPE_CHECKING:
    from e2e.bench.plan import Plan
    from e2e.bench.process import ProcessMeter
    from e2e.bench.servers import Side
    from e2e.crowd import Sample

SATURATED_CPU = 0.90
LEAST_FPS_FRACTION = 0.95
OTHERS_CPU = 0.05


@dataclass(frozen=True, slots=True)
class FanOutPoint:
    """One number of viewers. `…_cpu` are seconds of processor time per second.

    `server_cpu_sd` is the spread over the windows. `others_cpu` is what else ran on the server's
    core meanwhile. `saturated` points are left out of the slope, and so are those with a `flaw`:
    what, other than the server itself, set the limit.
    """

    viewers: int
    measured_s: float
    server_cpu: float
    server_cpu_sd: float
    receivers_cpu: float
    others_cpu: float
    fps_mean: float
    fps_min: float
    packets_per_s_per_viewer: float
    kbit_per_s_per_viewer: float
    packets: int
    packets_lost: int
    server_drops: dict[str, int]
    udp_receive_errors: int | None
    saturated: bool
    flaw: str | None


@dataclass(frozen=True, slots=True)
class FanOut:
    """One side. The slope is least squares over the points that are not saturated.

    `problem` says why the points end early, if they do.
    """

    points: list[FanOutPoint]
    problem: str | None
    cpu_per_further_viewer: float | None

    def at(self, viewers: int) -> FanOutPoint | None:
        return next((point for point in self.points if point.viewers == viewers), None)


def measure(side: Side, plan: Plan) -> FanOut:
    """Measure one side; raises `BenchError` where server and receivers cannot have a core each."""
    cores = two_cores()
    if cores is None:
        raise BenchError("fan-out needs two cores and a way to pin processes to them (Linux)")
    server_core, receivers_core = cores
    numbers = plan.our_viewers if side == "ours" else plan.stock_viewers
    points: list[FanOutPoint] = []
    problem = None
    with Server(side, server_core) as server, Crowd(server.offering, receivers_core) as crowd:
        try:
            for number in numbers:
                crowd.hold(number)
                time.sleep(plan.settle_s)
                points.append(_point(server, crowd, CoreMeter(server_core), plan))
        except BenchError as error:
            problem = f"with {number} viewers: {error}"
    return FanOut(points=points, problem=problem, cpu_per_further_viewer=_slope(points))


def _point(server: Server, crowd: Crowd, core: CoreMeter, plan: Plan) -> FanOutPoint:
    errors_before, drops_before = udp_receive_errors(), _drops(server)
    receivers_before_s, core_before_s = crowd.meter.cpu_s(), core.busy_s()
    first = crowd.count()
    windows = [_window(server.meter, plan.window_s) for _ in range(plan.windows)]
    last = crowd.count()
    measured_s = last.at_s - first.at_s
    receivers_cpu = (crowd.meter.cpu_s() - receivers_before_s) / measured_s
    server_cpu = statistics.fmean(windows)
    others_cpu = max(0.0, (core.busy_s() - core_before_s) / measured_s - server_cpu)
    errors_after, drops_after = udp_receive_errors(), _drops(server)
    lost_here = None if errors_after is None else errors_after - (errors_before or 0)

    fps = _fps(first, last)
    saturated = server_cpu > SATURATED_CPU or min(fps) < LEAST_FPS_FRACTION * FPS
    packets, lost, octets = _sums(first, last)
    per_viewer_s = measured_s * len(last.viewers)
    return FanOutPoint(
        viewers=len(last.viewers),
        measured_s=measured_s,
        server_cpu=server_cpu,
        server_cpu_sd=statistics.stdev(windows) if len(windows) > 1 else 0.0,
        receivers_cpu=receivers_cpu,
        others_cpu=others_cpu,
        fps_mean=statistics.fmean(fps),
        fps_min=min(fps),
        packets_per_s_per_viewer=packets / per_viewer_s,
        kbit_per_s_per_viewer=octets * 8 / 1000 / per_viewer_s,
        packets=packets,
        packets_lost=lost,
        server_drops={name: drops_after[name] - drops_before[name] for name in drops_after},
        udp_receive_errors=lost_here,
        saturated=saturated,
        flaw=_flaw(
            saturated=saturated,
            receivers_cpu=receivers_cpu,
            others_cpu=others_cpu,
            lost_here=lost_here,
        ),
    )


def _flaw(
    *, saturated: bool, receivers_cpu: float, others_cpu: float, lost_here: int | None
) -> str | None:
    if receivers_cpu > SATURATED_CPU:
        return f"the receivers needed {receivers_cpu:.2f} of their core"
    if lost_here:
        return f"the kernel threw away {lost_here} datagrams before they were read"
    # A server with time to spare is not disturbed by others; one without gets less than it asks.
    if saturated and others_cpu > OTHERS_CPU:
        return f"other programs took {others_cpu:.2f} of the server's core"
    return None


def _window(meter: ProcessMeter, window_s: float) -> float:
    start_s, start_cpu_s = time.monotonic(), meter.cpu_s()
    time.sleep(window_s)
    return (meter.cpu_s() - start_cpu_s) / (time.monotonic() - start_s)


def _fps(first: Sample, last: Sample) -> list[float]:
    pairs = zip(first.viewers, last.viewers, strict=True)
    span_s = last.at_s - first.at_s
    return [(after.video.frames - before.video.frames) / span_s for before, after in pairs]


def _sums(first: Sample, last: Sample) -> tuple[int, int, int]:
    packets = lost = octets = 0
    for before, after in zip(first.viewers, last.viewers, strict=True):
        for old, new in ((before.video, after.video), (before.audio, after.audio)):
            packets += new.packets - old.packets
            lost += new.lost - old.lost
            octets += new.octets - old.octets
    return packets, lost, octets


def _drops(server: Server) -> dict[str, int]:
    """Ask our server what it has itself thrown away, by stream; stock does not tell."""
    if server.side == "stock":
        return {}
    streams = server.status()["streams"]
    return {kind: int(streams[kind]["dropped"]) for kind in ("video", "audio")}


def _slope(points: list[FanOutPoint]) -> float | None:
    good = [point for point in points if point.flaw is None and not point.saturated]
    if len(good) < 2:
        return None
    fit = statistics.linear_regression(
        [point.viewers for point in good], [point.server_cpu for point in good]
    )
    return fit.slope
