"""The systems that people use today, with the same work as WAX: delay and load compare."""
