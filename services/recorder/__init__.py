"""Records everything that is said on the bus, as it is said."""
