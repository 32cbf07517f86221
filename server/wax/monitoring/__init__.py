"""Monitoring from outside: metrics and readiness, for operators of many servers."""
