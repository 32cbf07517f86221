"""Half an hour of what a host's evening is: somebody drives, others come and go."""
