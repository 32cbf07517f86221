"""`[metrics]`: where Prometheus scrapes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from wax.config.table import ConfigTable


class MetricSettings(ConfigTable):
    """Figures for Prometheus, on a port of their own; config/deploy/grafana.json is a dashboard for
    them.
    """

    port: Annotated[int, Field(ge=0, le=65535)] = 0
    """The TCP port of http://localhost:PORT/metrics, such as 9464; 0 serves none."""
    host: Annotated[str, Field(min_length=1)] = "localhost"
    """The name or address on which they are served. They name nobody, but are nobody else's
    business: keep "localhost" unless Prometheus runs on another machine of yours."""
