"""Logs that never block, and stay short and readable whatever strangers send."""
