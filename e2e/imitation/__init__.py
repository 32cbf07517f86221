"""A policy that learns to drive to the red pillar from what drivers did; run by hand."""
