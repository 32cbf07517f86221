"""`wax hook`: try the receivers of events, and describe the events."""
