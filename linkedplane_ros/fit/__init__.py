# SPDX-License-Identifier: Apache-2.0
"""Fitting a model to measured lengths and moment arms (thesis ch. 5)."""
