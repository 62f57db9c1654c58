# SPDX-License-Identifier: Apache-2.0
"""The commands of `linkedplane`, a module each: what it takes (`arguments`) and does (`run`)."""
