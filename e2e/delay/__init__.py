"""Delay: WAX and its peers over emulated networks, measured by one instrument."""
