"""One module for each experiment of chapter 5, and one for all systems side by side."""
