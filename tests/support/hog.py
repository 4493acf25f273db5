"""A program that takes one core, for as long as it is let."""

while True:
    pass
