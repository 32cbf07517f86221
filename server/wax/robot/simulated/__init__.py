"""A robot in a furnished flat: it drives, bumps, sees and hears, without any hardware.

Motion and sound are computed, pictures ray-cast. Nothing else in WAX depends on it.
"""
