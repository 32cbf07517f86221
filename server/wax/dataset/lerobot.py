"""Writes a folder in LeRobot's dataset format, version 3, one data and video file an episode.

It is written to ``FOLDER.partial`` and renamed when it is whole. A journal in it lists what is
finished, so that an export that was interrupted goes on with the next episode.
"""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from wax import __version__, state_dir
from wax.dataset import statistics
from wax.errors import StateError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from wax.dataset.frames import DatasetFrame
    from wax.dataset.statistics import Stats

VERSION: Final = "v3.0"
STATE: Final = "observation.state"
ACTION: Final = "action"
GATE: Final = "wax.gate"
HELD: Final = "wax.held"
CAPTURED: Final = "wax.captured_s"
"""Our own columns: what the gate did, whether the operator held anything, and when the picture was
captured, in seconds since 1970. LeRobot's `timestamp` is the frame's number divided by the rate."""
ABOUT: Final = "meta/wax.json"
"""What the columns mean, and what was left out, and why."""

_ODD: Final = re.compile(r"[^\w-]+", re.ASCII)
"""What the name of a feature, and of its folder, must not have."""
_JOURNAL: Final = "unfinished.jsonl"
_FILES_A_CHUNK: Final = 1000
_PLACE: Final = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA: Final = f"data/{_PLACE}.parquet"
_VIDEO: Final = f"videos/{{video_key}}/{_PLACE}.mp4"
_SOUND: Final = f"sound/{_PLACE}.ogg"
_EPISODES: Final = "meta/episodes/chunk-000/file-000.parquet"
_COUNTS: Final = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
_PANDAS: Final = {
    "index_columns": ["task"],
    "column_indexes": [],
    "columns": [
        {
            "name": name,
            "field_name": name,
            "pandas_type": kind,
            "numpy_type": numpy_kind,
            "metadata": None,
        }
        for name, kind, numpy_kind in (
            ("task_index", "int64", "int64"),
            ("task", "unicode", "object"),
        )
    ],
    "pandas_version": "2.2.0",
}
"""Tells pandas that the task's text is the index, where LeRobot looks for it."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What each row has; all episodes of a dataset have the same."""

    camera: str
    codec: str
    size: tuple[int, int]
    fps: int
    actions: tuple[str, ...]
    observed: tuple[str, ...]

    @property
    def video(self) -> str:
        """The feature of the picture."""
        return f"observation.images.{_ODD.sub('_', self.camera)}"

    def features(self) -> dict[str, dict[str, Any]]:
        """Return LeRobot's description of the columns."""
        width, height = self.size
        info = {
            "video.height": height,
            "video.width": width,
            "video.codec": self.codec,
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False,
            "video.fps": self.fps,
            "video.channels": 3,
            "has_audio": False,
        }
        picture: dict[str, Any] = {"dtype": "video", "shape": [height, width, 3]}
        picture |= {"names": ["height", "width", "channels"], "info": info}
        vectors = {STATE: self.observed, ACTION: self.actions}
        own = {GATE: "int64", HELD: "bool", CAPTURED: "float64"}
        return {
            self.video: picture,
            **{
                name: {"dtype": "float32", "shape": [len(names)], "names": list(names)}
                for name, names in vectors.items()
                if names
            },
            **{
                name: {"dtype": dtype, "shape": [1], "names": None}
                for name, dtype in (own | _COUNTS).items()
            },
        }


@dataclass(slots=True)
class Journal:
    """What an export has finished: its pieces of the tape, with their episodes."""

    pieces: list[list[float]] = field(default_factory=list)
    episodes: list[dict[str, Any]] = field(default_factory=list)
    left_out: list[dict[str, Any]] = field(default_factory=list)


class LeRobotFolder:
    """A dataset while it is written; `asked` is what must be the same for an export to go on.

    All methods may raise `OSError`; the constructor raises `StateError` for a folder that is in
    use.
    """

    def __init__(self, folder: Path, layout: Layout, asked: Mapping[str, Any]) -> None:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise StateError(
                f"{folder}: there is something in it already; name a folder that is new or empty"
            )
        self._folder = folder
        self._layout = layout
        self.partial = folder.with_name(f"{folder.name}.partial")
        self._asked = json.loads(json.dumps({"asked": asked, "features": layout.features()}))
        self.journal = self._resumed()

    def video_path(self, episode: int) -> Path:
        """Return where an episode's pictures are to be written, in a folder that exists."""
        return self._place(_VIDEO, episode)

    def sound_path(self, episode: int) -> Path:
        """Return where an episode's sound is to be written, in a folder that exists."""
        return self._place(_SOUND, episode)

    def add_episode(
        self,
        frames: Sequence[DatasetFrame],
        *,
        task: str,
        turn: int,
        pictures: Stats,
    ) -> dict[str, Any]:
        """Write an episode's rows; its pictures are already there. Return its record."""
        number = len(self.journal.episodes)
        first = self._frames
        tasks = self.tasks
        columns = _columns(frames, self._layout, number, first)
        columns["task_index"] = np.full(
            len(frames), tasks.index(task) if task in tasks else len(tasks), np.int64
        )
        path = self._place(_DATA, number)
        pq.write_table(_table(columns, self._layout.features()), path)
        state_dir.sync(path)
        state_dir.sync(self.video_path(number))
        stats = {name: statistics.of_rows(values) for name, values in columns.items()}
        record = {
            "turn": turn,
            "began_s": frames[0].captured_s,
            "length": len(frames),
            "task": task,
            "stats": statistics.as_json(stats | {self._layout.video: pictures}),
        }
        self.journal.episodes.append(record)
        return record

    def finish_piece(
        self,
        piece: Sequence[float],
        episodes: Sequence[dict[str, Any]],
        left_out: Sequence[dict[str, Any]],
    ) -> None:
        """Record that a piece of the tape is done: from here an interrupted export goes on."""
        self.journal.left_out += left_out
        line = {"piece": piece, "episodes": episodes, "left_out": left_out}
        self._append(line)

    def finish(self, about: Mapping[str, Any]) -> None:
        """Write what describes the dataset, and give the folder its name."""
        episodes = self.journal.episodes
        names = list(episodes[0]["stats"])
        stats = {
            name: statistics.merged([_arrays(one, name) for one in episodes]) for name in names
        }
        self._write_json("meta/stats.json", statistics.as_json(stats))
        told = {"wax_version": __version__, **about, "left_out": self.journal.left_out}
        self._write_json(ABOUT, told)
        tasks = self.tasks
        table = pa.table({"task_index": pa.array(range(len(tasks)), pa.int64()), "task": tasks})
        table = table.replace_schema_metadata({"pandas": json.dumps(_PANDAS)})
        pq.write_table(table, self.partial / "meta/tasks.parquet")
        (self.partial / _EPISODES).parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.Table.from_pylist(self._episode_rows()), self.partial / _EPISODES)
        self._write_json("meta/info.json", self._info())
        for path in self.partial.rglob("*"):
            state_dir.sync(path)
        (self.partial / _JOURNAL).unlink()
        self.partial.rename(self._folder)  # an empty folder of that name is replaced
        state_dir.sync(self._folder.absolute().parent)

    @property
    def tasks(self) -> list[str]:
        """The texts of the tasks, in the order of their numbers."""
        return list(dict.fromkeys(one["task"] for one in self.journal.episodes))

    @property
    def _frames(self) -> int:
        return sum(one["length"] for one in self.journal.episodes)

    def _place(self, pattern: str, episode: int) -> Path:
        chunk, file = divmod(episode, _FILES_A_CHUNK)
        place = pattern.format(chunk_index=chunk, file_index=file, video_key=self._layout.video)
        path = self.partial / place
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    def _episode_rows(self) -> list[dict[str, Any]]:
        rows, first = [], 0
        for number, one in enumerate(self.journal.episodes):
            chunk, file = divmod(number, _FILES_A_CHUNK)
            video = f"videos/{self._layout.video}"
            row = {
                "episode_index": number,
                "tasks": [one["task"]],
                "length": one["length"],
                "data/chunk_index": chunk,
                "data/file_index": file,
                "dataset_from_index": first,
                "dataset_to_index": first + one["length"],
                f"{video}/chunk_index": chunk,
                f"{video}/file_index": file,
                f"{video}/from_timestamp": 0.0,
                f"{video}/to_timestamp": one["length"] / self._layout.fps,
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
            }
            for feature, stats in one["stats"].items():
                row |= {f"stats/{feature}/{name}": values for name, values in stats.items()}
            rows.append(row)
            first += one["length"]
        return rows

    def _info(self) -> dict[str, Any]:
        layout, episodes = self._layout, self.journal.episodes
        return {
            "codebase_version": VERSION,
            "robot_type": "wax",
            "total_episodes": len(episodes),
            "total_frames": self._frames,
            "total_tasks": len(self.tasks),
            "chunks_size": _FILES_A_CHUNK,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": layout.fps,
            "splits": {"train": f"0:{len(episodes)}"},
            "data_path": _DATA,
            "video_path": _VIDEO,
            "features": layout.features(),
        }

    def _resumed(self) -> Journal:
        """Return the journal of an export that was interrupted, or of a new one."""
        path = self.partial / _JOURNAL
        if not path.is_file():
            if self.partial.exists() and any(self.partial.iterdir()):
                raise StateError(f"{self.partial}: is not ours, and in the way; move it away")
            self.partial.mkdir(parents=True, exist_ok=True)
            self._append(self._asked)
            return Journal()
        lines = [one for one in path.read_bytes().splitlines(keepends=True) if one.endswith(b"\n")]
        if not lines or json.loads(lines[0]) != self._asked:
            raise StateError(
                f"{self.partial}: an export with other options was interrupted here; delete it, or"
                " use those options again"
            )
        journal = Journal()
        for line in map(json.loads, lines[1:]):
            journal.pieces.append(line["piece"])
            journal.episodes += line["episodes"]
            journal.left_out += line["left_out"]
        with path.open("r+b") as file:  # a line that was not finished is written again
            file.truncate(sum(map(len, lines)))
        return journal

    def _append(self, line: Mapping[str, Any]) -> None:
        with (self.partial / _JOURNAL).open("ab") as file:
            file.write(json.dumps(line).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())

    def _write_json(self, name: str, content: object) -> None:
        path = self.partial / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(content, indent=4, ensure_ascii=False), encoding="utf-8")


def _columns(
    frames: Sequence[DatasetFrame], layout: Layout, episode: int, first: int
) -> dict[str, NDArray[Any]]:
    numbers = np.arange(len(frames), dtype=np.int64)
    columns: dict[str, NDArray[Any]] = {}
    if layout.observed:
        columns[STATE] = np.array([one.observed for one in frames], np.float32)
    return columns | {
        ACTION: np.array([one.action for one in frames], np.float32),
        GATE: np.array([one.gate for one in frames], np.int64),
        HELD: np.array([one.held for one in frames], np.bool_),
        CAPTURED: np.array([one.captured_s for one in frames], np.float64),
        "timestamp": (numbers / layout.fps).astype(np.float32),
        "frame_index": numbers,
        "episode_index": np.full(len(frames), episode, np.int64),
        "index": numbers + first,
    }


def _table(columns: Mapping[str, NDArray[Any]], features: Mapping[str, Any]) -> pa.Table:
    arrays = {}
    for name, feature in features.items():
        if feature["dtype"] == "video":
            continue
        values = columns[name]
        kind = pa.from_numpy_dtype(values.dtype)
        flat = pa.array(values.ravel(), kind)
        length = feature["shape"][0]
        arrays[name] = flat if length == 1 else pa.FixedSizeListArray.from_arrays(flat, length)
    return pa.table(arrays)


def _arrays(episode: Mapping[str, Any], feature: str) -> Stats:
    return {name: np.array(values, float) for name, values in episode["stats"][feature].items()}
