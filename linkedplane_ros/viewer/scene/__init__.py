# SPDX-License-Identifier: Apache-2.0
"""What is drawn: markers from the wire, their geometry, and the scene that shows them."""
