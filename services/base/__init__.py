"""The base's admittance: a free-floating body that the external wrench pushes about, while it is enabled."""
