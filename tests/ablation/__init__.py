"""The effect of half and double of each constant of congestion control, in simulation."""
