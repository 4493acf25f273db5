"""The load experiment: a bag is hung from the tool, made heavier than the limit, and taken off."""
