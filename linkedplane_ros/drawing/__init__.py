"""A state as shapes for markers and scenes, and as pictures."""
