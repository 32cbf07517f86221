"""What strangers' traffic may cost the event loop: budgets, limits of each pass, long steps."""
