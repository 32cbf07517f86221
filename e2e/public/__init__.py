"""Open to the public: strangers who flood, dawdle and come back; ``python -m e2e.public``."""
