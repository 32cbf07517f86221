"""A differential-drive robot in a furnished flat, with an eye and an ear of its own."""
