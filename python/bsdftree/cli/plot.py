"""``bsdftree plot``: see the whole BSDF."""
