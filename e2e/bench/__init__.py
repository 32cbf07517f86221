"""The benchmark: WAX and a stock aiortc server, the same work, the same machine, the same run."""
