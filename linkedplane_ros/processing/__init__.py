"""Recordings written again with the muscle's state beside the motion."""
