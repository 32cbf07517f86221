"""What strangers' bytes may cost: charged where they become work, before they are parsed."""
