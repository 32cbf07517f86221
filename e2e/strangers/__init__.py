"""Open to the public: strangers who attack, and networks that fail; ``python -m e2e.strangers``."""
