"""A server open to the public: strangers who attack, and networks that fail."""
