"""A generated film of a talking head with its voice, and how lips and voice are judged by it."""

from e2e.delay.talking_head.film import film_file
from e2e.delay.talking_head.lips import LipLag, lip_lag

__all__ = ["LipLag", "film_file", "lip_lag"]
