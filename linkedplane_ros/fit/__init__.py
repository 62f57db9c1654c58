"""Fitting a model to measured lengths and moment arms (thesis ch. 5)."""
