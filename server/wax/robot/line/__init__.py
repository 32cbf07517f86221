"""What every driver on a line shares: which set-point counts, and keeping the line open."""
