"""A twist's motion in the plane as a complex number: ahead is real, sideways to the left imaginary.

The oracles calculate with it, while the server's code has two floats.
"""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist


def velocity(twist: Twist) -> complex:
    """Return how fast the robot's middle moves, in m/s."""
    return complex(twist.linear_mps, twist.lateral_mps)


def gained(was: complex, now: complex) -> float:
    """Return how far `now` is from every speed to which `was` may have been braked."""
    way = was / abs(was) if was else 0j
    return abs(now - way * min(abs(was), max(0.0, (now * way.conjugate()).real)))


def fraction(twist: Twist, limits: Limits) -> float:
    """Return the length of a twist's velocity as a fraction of the limit in its direction."""
    parts = ((twist.linear_mps, limits.linear_mps), (twist.lateral_mps, limits.lateral_mps))
    return abs(complex(*(part / most if part else 0.0 for part, most in parts)))


def is_same(twist: Twist, other: Twist) -> bool:
    """Whether two twists are equal but for rounding; a part that is 0 must be 0 in both."""
    return all(
        math.isclose(one, two, rel_tol=1e-12, abs_tol=1e-300 if one and two else 0.0)
        for one, two in zip(astuple(twist), astuple(other), strict=True)
    )
