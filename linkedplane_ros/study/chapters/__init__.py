# SPDX-License-Identifier: Apache-2.0
"""The report's chapters: text, tables and pictures."""
