"""Mutation testing of what keeps the robot standing: small faults that the tests must notice."""
