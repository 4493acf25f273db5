"""How messages travel: buses, payloads, and both ends of a topic."""
