"""The cost of the page itself: time to the first picture, work, memory, and an input's delay."""
