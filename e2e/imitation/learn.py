"""Trains a small policy on the CPU from what `drive` exported, and judges it on a held-out turn.

`python e2e/imitation/learn.py FOLDER/dataset`, in an environment of its own that has PyTorch, PyAV
and pyarrow. It predicts the set-point from one picture, and is better than the mean action by the
share of the squared error that it saves, with each action's spread as its unit.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import av
import numpy as np
import pyarrow.parquet as pq
import torch
from torch import nn

TASK = "drive to the red pillar"
WIDTH, HEIGHT = 64, 48
EPOCHS = 40
BATCH = 64


def episodes(folder: Path) -> list[tuple[torch.Tensor, torch.Tensor]]:
    """Return pictures and actions of each episode with the task, in their order."""
    tasks = pq.read_table(folder / "meta/tasks.parquet").to_pylist()
    (task,) = (one["task_index"] for one in tasks if one["task"] == TASK)
    found = []
    for path in sorted((folder / "data").rglob("*.parquet")):
        rows = pq.read_table(path).to_pylist()
        if rows[0]["task_index"] != task:
            continue
        (video,) = (folder / "videos").glob(f"*/{path.parent.name}/{path.stem}.mp4")
        with av.open(str(video)) as media:
            pictures = [
                one.to_ndarray(format="rgb24", width=WIDTH, height=HEIGHT)
                for one in media.decode(video=0)
            ]
        actions = [row["action"] for row in rows]
        assert len(pictures) == len(actions)
        shown = torch.from_numpy(np.stack(pictures)).permute(0, 3, 1, 2).float() / 255
        found.append((shown, torch.tensor(actions)))
    return found


def policy() -> nn.Module:
    """Return an untrained policy."""
    layers: list[nn.Module] = []
    for before, after in ((3, 16), (16, 32), (32, 32)):
        layers += [nn.Conv2d(before, after, 5, stride=2, padding=2), nn.ReLU()]
    return nn.Sequential(*layers, nn.Flatten(), nn.LazyLinear(64), nn.ReLU(), nn.Linear(64, 2))


def trained(pictures: torch.Tensor, actions: torch.Tensor) -> nn.Module:
    """Train a policy on actions in units of their spread."""
    model = policy()
    model(pictures[:1])
    optimizer = torch.optim.Adam(model.parameters(), 1e-3)
    for _ in range(EPOCHS):
        for batch in torch.randperm(len(pictures)).split(BATCH):
            optimizer.zero_grad()
            nn.functional.mse_loss(model(pictures[batch]), actions[batch]).backward()
            optimizer.step()
    return model.eval()


def main(folder: Path) -> None:
    """Print how much better than the mean action the policy is."""
    torch.manual_seed(63)
    *turns, (seen, driven) = episodes(folder)
    pictures, actions = (torch.cat(one) for one in zip(*turns, strict=True))
    mean, spread = actions.mean(0), actions.std(0)
    began_s = time.monotonic()
    model = trained(pictures, (actions - mean) / spread)
    took_s = time.monotonic() - began_s
    with torch.no_grad():
        errors = model(seen) - (driven - mean) / spread
    of_policy = float((errors**2).mean())
    of_mean = float((((driven - mean) / spread) ** 2).mean())
    print(
        f"trained on {len(pictures)} frames of {len(turns)} turns in {took_s:.0f} s; on the"
        f" held-out turn (n = {len(seen)} frames)"
        f" {1 - of_policy / of_mean:.0%} better than the mean action"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
