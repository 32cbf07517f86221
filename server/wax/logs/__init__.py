"""Logs that never block, and that stay short and legible whatever strangers send."""
