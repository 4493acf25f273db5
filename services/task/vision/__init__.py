"""From an image to a marker that is believed."""
