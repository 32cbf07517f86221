"""What the page itself takes: time to the first picture, work, memory, and an input's way out."""
