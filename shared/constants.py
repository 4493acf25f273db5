"""Constants of nature."""

GRAVITY = 9.81
"""Standard gravity [m/s2], as the contract rounds it: a mass of 1 kg that hangs from the tool gives -9.81 N."""
