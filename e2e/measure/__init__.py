"""Runs measurements, keeps the results, publishes the figures, renders the tables."""
