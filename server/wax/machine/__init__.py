"""Uses of the operating system: memory, priority, threads, child processes, systemd."""
