"""From a file to a `Run`, or one sentence about why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ValidationError

from e2e.lab.results import Run

if TYPE_CHECKING:
    from pathlib import Path


class RunFileError(Exception):
    """A sentence for a person: what is wrong with the file and what to do."""


def load(path: Path) -> Run:
    """Read what a run of the lab left behind; raises `RunFileError`."""
    try:
        text = path.read_bytes()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise RunFileError(f"{path} cannot be read: {why}; name the JSON of a lab run.") from error
    try:
        return Run.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        if first["type"] == "json_invalid":
            raise RunFileError(f"{path} is not JSON; name the JSON of a lab run.") from error
        where = ".".join(str(part) for part in first["loc"]) or "the whole file"
        raise RunFileError(
            f"{path} is not a run of this lab ({where}: {first['msg'].lower()}); "
            "name the JSON that this version of the lab has written."
        ) from error
