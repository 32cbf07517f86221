"""Pure: what one viewer's link carries, from what its browser tells of every packet."""

from wax.sync.estimate.estimator import LinkEstimator
from wax.sync.estimate.packets import HEADER_BYTES, payload_bytes
from wax.sync.estimate.probing import STARTING_RATE_BPS

__all__ = ["HEADER_BYTES", "STARTING_RATE_BPS", "LinkEstimator", "payload_bytes"]
