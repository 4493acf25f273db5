"""The carrying task: finds the panel, grasps it, carries it with a person, and lets go when it stands on the ground."""
