"""What each constant of the congestion control is worth: half and double of it, in simulation."""
