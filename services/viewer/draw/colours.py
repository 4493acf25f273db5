"""Colours [r, g, b, a], legible on a dark and on a bright page."""

RED, GREEN, BLUE = (224, 60, 60), (64, 176, 80), (70, 130, 240)
AXES = (RED, GREEN, BLUE)
"""Of x, y, z, here as in the scene's coordinate axes."""
PALE = ((240, 140, 140), (150, 205, 155), (150, 190, 245))
"""Of what goes with x, y, z: torques beside forces."""
FAINT = ((224, 60, 60, 110), (64, 176, 80, 110), (70, 130, 240, 110))
"""Of limits and error bands."""
AMBER, GREY, YELLOW, PURPLE = (224, 150, 30), (130, 130, 135), (240, 190, 30), (190, 90, 210)
TEAL = (30, 160, 170)
