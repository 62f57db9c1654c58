"""The study's figures: the muscle at its poses, and charts."""
