# SPDX-License-Identifier: Apache-2.0
"""The thesis's case study, done again: experiments, interference, fidelity; tables and figures.

The way of the data: experiments -> interference, fidelity -> chapters (text, tables, figures) ->
folder. Inside all is in m and rad; tables and figures, for people, are in mm and deg.
"""
