"""The configuration with which WAX is started for a cell."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

import pytest
import tomlkit

from e2e.delay.cell import Cell
from e2e.delay.systems.settings import THESIS, settings
from e2e.peers.sizes import SIZES
from wax.config import settings as config

if TYPE_CHECKING:
    from e2e.delay.names import SystemName


def cell(system: SystemName, **keys: Any) -> Cell:
    return Cell(experiment="E1", profile="lan", system=system, **keys)


def read(system: SystemName, **keys: Any) -> config.Settings:
    text = tomlkit.dumps(settings(cell(system, **keys)))
    return config.parse(tomllib.loads(text), "a test")


@pytest.mark.parametrize("system", ["audio-master", "operator"])
def test_our_policies_run_as_shipped(system: SystemName) -> None:
    """Except for address, sources and the length of a turn, WAX runs with its shipped defaults."""
    given_, shipped = read(system), config.Settings()
    assert (given_.video.source, given_.audio.source) == ("testcard", "testcard")
    for section in ("sync", "drive", "robot"):
        assert getattr(given_, section) == getattr(shipped, section)
    assert given_.video.renditions == shipped.video.renditions
    assert given_.turns.join == "ask"


def test_a_large_picture_has_its_size_and_rate() -> None:
    """The camera and its best step are as large as the peers' picture, and may cost as much."""
    video, hd = read("operator", size="1280x720").video, SIZES["1280x720"]
    best = video.renditions[0]
    assert (video.width, video.height) == (best.width, best.height) == (hd.width, hd.height)
    assert best.bitrate_bps == hd.bitrate_bps
    assert {one.width * 9 for one in video.renditions} == {
        one.height * 16 for one in video.renditions
    }


def test_video_first_is_for_both_roles() -> None:
    """Under video-first neither the operator nor the observers wait for sound."""
    sync = read("video-first").sync
    assert sync.operator.policy == sync.observer.policy == "video-first"


def test_the_thesis_keeps_its_constants() -> None:
    """Of the shipped file, the cell changes only the audio MU and the sources.

    WAX accepts the resulting configuration.
    """
    tree = settings(cell("thesis", audio_mu_ms=200))
    assert tree["thesis"].pop("audio_mu_ms") == 200
    assert tree["video"].pop("source") == tree["audio"].pop("source") == "testcard"
    shipped = tomllib.loads(THESIS.read_text(encoding="utf-8"))
    own_mu_ms = shipped["thesis"].pop("audio_mu_ms")
    del shipped["turns"]["turn_s"]
    for name, keys in shipped.items():
        for key, value in keys.items():
            assert tree[name][key] == value
    assert settings(cell("thesis"))["thesis"]["audio_mu_ms"] == own_mu_ms
    assert read("thesis", audio_mu_ms=300).turns.join == "auto"
