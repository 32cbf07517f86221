"""The effect of halving and doubling each constant of congestion control, in simulation."""
