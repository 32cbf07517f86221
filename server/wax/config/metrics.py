"""`[metrics]`: where Prometheus scrapes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class MetricSettings(ConfigTable):
    """`[metrics]`: where Prometheus scrapes them."""

    port: Annotated[int, Field(ge=0, le=65535)] = 0
    host: Annotated[str, Field(min_length=1)] = "localhost"
