"""The manual `config/wax.toml`, which is written from the settings."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import pytest
from pydantic import BaseModel, Field

from wax.config import manual
from wax.config import settings as config
from wax.config.allowed import said
from wax.config.ladder import DRIVING
from wax.config.video import AUTO, VideoSettings, ladder_settings

if TYPE_CHECKING:
    from collections.abc import Iterator

MANUAL = Path(__file__).parents[2] / "config" / "wax.toml"
UNITS = {
    "_ms": "millisecond",
    "_s": "second",
    "_hz": "times a second",
    "fps": "pictures a second",
    "_bps": "bits a second",
    "_mps": "metres a second",
    "_rps": "radians a second",
    "_m": "metres",
    "_deg": "degrees",
    "width": "pixel",
    "height": "pixel",
    "baud": "bits a second",
}


def models(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """Return a model, and those of all tables in it."""
    yield model
    for field in model.model_fields.values():
        for inner in manual.models_in(field.annotation):
            yield from models(inner)


def test_the_manual_is_what_the_settings_say() -> None:
    """The manual has each key's purpose, range and default of today; else `make manual` is due."""
    assert MANUAL.read_text(encoding="utf-8") == manual.whole(config.Settings)


def test_the_manual_equals_the_defaults() -> None:
    """The manual, taken as a configuration, is the default one."""
    defaults = config.Settings()
    told = defaults.model_dump()
    told["video"] |= dict.fromkeys(("width", "height", "renditions"), AUTO)
    assert tomllib.loads(MANUAL.read_text(encoding="utf-8")) == told
    assert config.load(MANUAL) == defaults
    assert config.load(None) == defaults


def test_the_manuals_ladder_is_the_automatic_one() -> None:
    """What the manual shows as the ladder of 1280×720 is what "auto" makes."""
    text = manual.purposes(VideoSettings)["renditions"]
    (shown,) = re.findall(r"renditions = \[.*\]", text, re.DOTALL)
    made = ladder_settings(1280, 720, 30.0, DRIVING)
    assert tomllib.loads(shown)["renditions"] == [one.model_dump() for one in made]


@pytest.mark.parametrize("model", dict.fromkeys(models(config.Settings)))
def test_every_key_has_a_purpose_with_its_unit(model: type[BaseModel]) -> None:
    """Each key says what it is for in two words at least, and its unit."""
    for key, text in manual.purposes(model).items():
        if not manual.models_in(model.model_fields[key].annotation):
            assert len(text.split()) >= 2, key
        unit = next((unit for suffix, unit in UNITS.items() if key.endswith(suffix)), "")
        assert unit in text.lower(), key


class Wheel(BaseModel):
    """Its wheels, one table for each."""

    spokes: int = 32
    """How many spokes it has."""
    tyre: str
    """What is on its rim."""


class Lamp(BaseModel):
    """What lights its way."""

    watts: Annotated[float, Field(ge=0, le=9)] = 2.5
    """How bright it is.
    """


class Dynamo(Lamp):
    """Machines that light the lamp."""

    volts: int = 6
    """What it gives."""


class Bicycle(BaseModel):
    """A bicycle."""

    bell: Annotated[str, said("a sound")] = "ring"
    r"""What it says, "" for "\r".

    Example: bell = "clang"
    """
    gears: list[Annotated[int, Field(ge=1)]] = []
    """Its gears:
      1  is slow.
    The last is fast."""
    load_kg: int = 10_000
    """What it carries, as it also says on the road, to whoever asks it there by the command
    `bicycle load`."""
    wheel: list[Wheel] = []
    dynamo: list[Dynamo] = []
    lamp: Lamp = Lamp()


def test_what_stands_at_a_key_is_in_the_manual() -> None:
    """The manual takes its words from docstrings, ranges from types, and says nothing twice."""
    assert manual.whole(Bicycle) == (
        "# A bicycle.\n"
        "\n"
        '# What it says, "" for "\\r".\n'
        '# Example: bell = "clang"\n'
        "# Allowed: a sound\n"
        'bell = "ring"\n'
        "\n"
        "# Its gears:\n"
        "#   1  is slow.\n"
        "# The last is fast.\n"
        "# Each is a whole number at least 1.\n"
        "# Allowed: a list of numbers\n"
        "gears = []\n"
        "\n"
        "# What it carries, as it also says on the road, to whoever asks it there by the command\n"
        "# `bicycle load`.\n"
        "# Allowed: a whole number\n"
        "load_kg = 10_000\n"
        "\n"
        "# Its wheels, one table for each.\n"
        "# Write a table [[wheel]] for each, below all other keys. Keys of each:\n"
        "#   tyre    What is on its rim. Allowed: a text.\n"
        "#   spokes  How many spokes it has. Allowed: a whole number. Default: 32\n"
        "# Allowed: a list of tables\n"
        "wheel = []\n"
        "\n"
        "# Machines that light the lamp.\n"
        "# Write a table [[dynamo]] for each, below all other keys. Keys of each:\n"
        "#   volts  What it gives. Allowed: a whole number. Default: 6\n"
        "#   watts: as in [lamp].\n"
        "# Allowed: a list of tables\n"
        "dynamo = []\n"
        "\n"
        "# What lights its way.\n"
        "[lamp]\n"
        "# How bright it is.\n"
        "# Allowed: a number from 0 to 9\n"
        "watts = 2.5\n"
    )
