"""Webhooks: posts events to the host's programs from bounded queues, a Stop ahead of the rest."""
