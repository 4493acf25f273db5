"""Quantities that the certified law counts with: contacts, caps, travel in flight, yielding."""
