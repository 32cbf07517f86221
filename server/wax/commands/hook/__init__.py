"""`wax hook`: tests the webhooks, and describes the events."""
