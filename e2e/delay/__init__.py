"""The lab: WAX and its peers over shaped networks, read by one instrument."""
