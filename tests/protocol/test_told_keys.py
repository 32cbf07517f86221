"""What pages are told of the configuration by its keys' own names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.config.controls import ControlSettings, GaugeSettings
from wax.config.page import LinkSettings, PageSettings
from wax.config.voice import VoiceSettings
from wax.protocol import messages

if TYPE_CHECKING:
    from pydantic import BaseModel


@pytest.mark.parametrize(
    ("told", "table"),
    [
        (messages.PageInfo, PageSettings),
        (messages.PageLink, LinkSettings),
        (messages.VoiceRules, VoiceSettings),
        (messages.ControlInfo, ControlSettings),
        (messages.GaugeInfo, GaugeSettings),
    ],
)
def test_each_field_is_a_key(told: type[BaseModel], table: type[BaseModel]) -> None:
    """Pages are told nothing of these tables that is no key in them, and so always its default."""
    assert told.model_fields.keys() <= table.model_fields.keys()
