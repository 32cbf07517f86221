"""What people use today, with the same work as WAX: the lab and the benchmarks compare."""
