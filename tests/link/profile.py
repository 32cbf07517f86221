"""Profiles: how a network treats packets in both directions, each a TOML file."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from tests.link import trace
from tests.link.errors import ProfileError

from wax.config import allowed

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

FOLDER: Final = Path(__file__).parent / "profiles"
DRIVE: Final = ".down"
NORMAL_CUT: Final = 3.0
"""Normal jitter is cut at this many standard deviations, so that no delay is negative."""

Chance = Annotated[float, Field(ge=0, le=1)]
DelayMs = Annotated[float, Field(ge=0, le=60_000)]
RateBps = Annotated[int, Field(ge=1_000, le=10_000_000_000)]
QueueMs = Annotated[float, Field(gt=0, le=60_000)]
QueueBytes = Annotated[int, Field(ge=1, le=1_000_000_000)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class Jitter(_Table):
    """The addition to each packet's delay, random for each.

    `ms` is the half width (uniform), the standard deviation (normal, cut at 3 of them; half-normal,
    its absolute value) or the scale (pareto: a heavy tail above the delay, Lomax with `shape`, cut
    at `at_most_ms`).
    """

    distribution: Literal["uniform", "normal", "half-normal", "pareto"]
    ms: Annotated[float, Field(gt=0, le=10_000)]
    shape: Annotated[float, Field(gt=1, le=100)] = 3.0
    at_most_ms: Annotated[float, Field(gt=0, le=60_000)] = 1000.0

    @model_validator(mode="after")
    def _tail_only_for_pareto(self) -> Self:
        if self.distribution != "pareto" and self.model_fields_set & {"shape", "at_most_ms"}:
            raise ValueError("shape and at_most_ms belong to pareto only; take them out")
        return self

    @property
    def earliest_ms(self) -> float:
        """The most by which it can shorten the delay."""
        return {"uniform": self.ms, "normal": NORMAL_CUT * self.ms}.get(self.distribution, 0.0)


class Stalls(_Table):
    """Spikes: now and then everything stops and is then released at once.

    Between them lie 0.5 to 1.5 times `every_s`, uniform, so that a short run also has some; their
    length is uniform, too.
    """

    every_s: Annotated[float, Field(gt=0, le=3600)]
    at_least_ms: Annotated[float, Field(ge=0, le=60_000)]
    at_most_ms: Annotated[float, Field(gt=0, le=60_000)]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.at_least_ms > self.at_most_ms:
            raise ValueError("at_least_ms is above at_most_ms; exchange them")
        return self


class Loss(_Table):
    """Gilbert–Elliott: two states, each with its loss rate, which may change at each packet.

    With `in_good` alone the losses are independent. Starts in the good state.
    """

    in_good: Chance = 0.0
    in_bad: Chance = 1.0
    good_to_bad: Chance = 0.0
    bad_to_good: Annotated[float, Field(gt=0, le=1)] = 1.0

    @property
    def bad_share(self) -> float:
        """The fraction of packets in the bad state in the long run."""
        return self.good_to_bad / (self.good_to_bad + self.bad_to_good)

    @property
    def mean(self) -> float:
        """The fraction of packets that are lost in the long run."""
        return self.in_good + self.bad_share * (self.in_bad - self.in_good)


class Conditions(_Table):
    """What one direction does at one time; rates and queues count bytes of IP packets.

    A packet joins the queue or is dropped (drop-tail), is serialised at the rate, may be lost on
    the way, and arrives after stall, delay and jitter; never before an earlier one unless
    `reorder`, so that packets close together all have the latest one's jitter. Without `rate_bps`
    and `trace` serialisation takes no time.
    """

    rate_bps: RateBps | None = None
    trace: str | None = None
    queue_ms: QueueMs | None = None
    queue_bytes: QueueBytes | None = None
    delay_ms: DelayMs = 0.0
    jitter: Jitter | None = None
    stalls: Stalls | None = None
    loss: Loss = Loss()
    outage: bool = False
    reorder: bool = False

    @model_validator(mode="after")
    def _queue_is_stated(self) -> Self:
        if (self.queue_ms is None) == (self.queue_bytes is None):
            raise ValueError("state the length of the queue: either queue_ms or queue_bytes")
        if self.queue_ms is not None and self.rate_bps is None and self.trace is None:
            raise ValueError("queue_ms needs rate_bps or trace; without them give queue_bytes")
        if self.rate_bps is not None and self.trace is not None:
            raise ValueError("rate_bps and trace exclude each other; take one out")
        return self

    @model_validator(mode="after")
    def _no_delay_is_negative(self) -> Self:
        if self.jitter is not None and self.jitter.earliest_ms > self.delay_ms:
            raise ValueError(
                f"jitter takes up to {self.jitter.earliest_ms:g} ms from a delay of "
                f"{self.delay_ms:g} ms; make delay_ms longer"
            )
        return self


class Change(_Table):
    """From `at_s` on, counted from the start of the changes, these keys differ."""

    at_s: Annotated[float, Field(gt=0, le=86_400)]
    rate_bps: RateBps | None = None
    queue_ms: QueueMs | None = None
    queue_bytes: QueueBytes | None = None
    delay_ms: DelayMs | None = None
    jitter: Jitter | None = None
    stalls: Stalls | None = None
    loss: Loss | None = None
    outage: bool | None = None


class DirectionSettings(Conditions):
    """`[down]` or `[up]`: how it starts and what changes."""

    changes: Annotated[list[Change], Field(max_length=1000)] = []

    @model_validator(mode="after")
    def _changes_fit(self) -> Self:
        if self.outage:
            raise ValueError("outage belongs into a change, with a later one that ends it")
        times = [change.at_s for change in self.changes]
        if any(later <= earlier for earlier, later in pairwise(times)):
            raise ValueError("the changes are not in the order of at_s")
        if self.steps()[-1][1].outage:
            raise ValueError("the last change is an outage; end it with another change")
        ruled = {key for change in self.changes for key in change.model_fields_set}
        if self.trace is not None and ruled & {"rate_bps", "outage"}:
            raise ValueError("with a trace the changes cannot set rate_bps or outage; it says both")
        return self

    def steps(self) -> list[tuple[float, Conditions]]:
        """Return the conditions with the time at which each starts, the first at 0 s."""
        keys = {name: getattr(self, name) for name in Conditions.model_fields}
        steps = [(0.0, Conditions(**keys))]
        for change in self.changes:
            fresh = {name: getattr(change, name) for name in change.model_fields_set - {"at_s"}}
            if "queue_ms" in fresh or "queue_bytes" in fresh:
                keys |= {"queue_ms": None, "queue_bytes": None}
            keys |= fresh
            try:
                steps.append((change.at_s, Conditions(**keys)))
            except ValidationError as error:
                said = error.errors()[0]["msg"].removeprefix("Value error, ")
                raise ValueError(f"the change at {change.at_s:g} s: {said}") from error
        return steps


class Profile(_Table):
    """A network: `down` is from the server to the browser, `up` the way back."""

    about: Annotated[str, Field(min_length=1)]
    seed: Annotated[int, Field(ge=0)] = 1
    down: DirectionSettings
    up: DirectionSettings


def names() -> list[str]:
    """Return the profiles that are shipped."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def load(name: str) -> Profile:
    """Read a shipped profile by its name, or any by its path, which ends in ``.toml``.

    A trace in it is named relative to the profile. A path that ends in ``.down`` is a recorded
    drive, with its uplink next to it. Raises `ProfileError`.
    """
    if name.endswith(DRIVE):
        return _drive(Path(name))
    path = Path(name) if name.endswith(".toml") else FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and name not in names():
        near = get_close_matches(name, names(), 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise ProfileError(f"there is no profile {name}{hint} (there are: {', '.join(names())})")
    try:
        tree = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ProfileError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ProfileError(f"{path}: is not valid TOML: {error}") from error
    for way in ("down", "up"):
        table = tree.get(way)
        if isinstance(table, dict) and isinstance(table.get("trace"), str):
            table["trace"] = str((path.parent / table["trace"]).resolve())
            trace.read(table["trace"])
    return parse(tree, str(path))


def _drive(down: Path) -> Profile:
    """Return a recorded pair of traces, with 30 ms each way and a queue of 600 ms."""
    ways = {}
    for way, path in (("down", down), ("up", down.with_suffix(".up"))):
        trace.read(str(path))
        ways[way] = {"trace": str(path.resolve()), "queue_ms": 600, "delay_ms": 30}
    return parse({"about": f"recorded while driving: {down.stem}", **ways}, str(down))


def parse(tree: dict[str, Any], name: str) -> Profile:
    """Check a parsed TOML tree; messages call the file `name`.

    Raises `ProfileError`: one sentence for each key that is wrong.
    """
    try:
        return Profile.model_validate(tree)
    except ValidationError as error:
        schema = _without_null(Profile.model_json_schema())
        lines = dict.fromkeys(_sentence(problem, schema) for problem in error.errors())
        raise ProfileError("\n".join(f"{name}: {line}" for line in lines)) from error


def _without_null(schema: Any) -> Any:
    """Remove null from the types of optional keys: TOML has no null."""
    if isinstance(schema, list):
        return [_without_null(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    given = [branch for branch in schema.get("anyOf", []) if branch.get("type") != "null"]
    if len(given) == 1:
        schema = {**schema, **given[0]}
        del schema["anyOf"]
    return {name: _without_null(value) for name, value in schema.items()}


def _sentence(problem: ErrorDetails, schema: allowed.Schema) -> str:
    key, known = allowed.find(schema, problem["loc"])
    if problem["type"] == "extra_forbidden" or known is None:
        near = get_close_matches(
            str(problem["loc"][-1]), allowed.neighbours(schema, problem["loc"]), 1
        )
        return f"{key}: there is no such key" + (f"; did you mean {near[0]}?" if near else "")
    if problem["type"] == "missing":
        return f"{key}: is missing; allowed is {allowed.words(known)}"
    if problem["type"] == "value_error":
        return f"{key}: {problem['msg'].removeprefix('Value error, ')}"
    return f"{key}: got {allowed.shown(problem['input'])}; allowed is {allowed.words(known)}"
