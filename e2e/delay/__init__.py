"""Delay: WAX and its peers over emulated networks, read by one instrument."""
