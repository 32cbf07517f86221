"""The voice, spoken once for all tests of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.delay.talking_head.voice import speak
from e2e.harness.missing import missing
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@pytest.fixture(scope="session")
def voice() -> NDArray[np.int16]:
    try:
        return speak()
    except NotRunError as error:
        missing(str(error))
