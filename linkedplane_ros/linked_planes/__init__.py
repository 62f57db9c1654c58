# SPDX-License-Identifier: Apache-2.0
"""The thesis's chapter 4, in its words: bands, planes, spheres, and the theta of least length."""
