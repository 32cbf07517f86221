"""`wax prove-stop`: cut each link of the real installation in turn, and measure until it stands."""
