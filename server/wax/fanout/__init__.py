"""From one encoder to every viewer's lane."""
