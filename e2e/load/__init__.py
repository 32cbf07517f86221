"""Compares WAX with a stock aiortc server: same work, same machine, same run."""
