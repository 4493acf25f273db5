"""How often something false is stated: sensors and cameras drawn at random, before the real services."""
