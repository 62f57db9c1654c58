"""The muscle in a browser: the node muscle_viewer. It shows what is published and solves nothing.

The way of the data: messages (wire) -> newest state -> geometry -> scene, panel and plots of the
`viser` library, at the screen's rate; and from sliders and buttons back (motions) to joint states.
"""
