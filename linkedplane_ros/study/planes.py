"""The bands' planes at a solved pose, and the circles that wrapped bands lie on (thesis App. B, C).

The solver keeps these to itself; here they are built again, literally, for pictures and distances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..solver import MuscleState, WrapState

Floats = npt.NDArray[np.float64]


def normals(state: MuscleState) -> Floats:
    """Return the unit normals (n, 3) of the bands' planes, scapula frame (right shoulder; App. B).

    The first plane makes the angle theta with the reference plane, each other one its phi with the
    plane before it, about the line from the band's origin to its insertion.
    """
    muscle = state.solver.muscle
    before, found = muscle.reference_normal, np.empty((len(muscle.band_names), 3))
    angles = [state.theta, *muscle.plane_angles[1:].tolist()]
    for i, (P, S, phi) in enumerate(zip(muscle.origins, state.insertions, angles, strict=True)):
        u = (S - P) / np.linalg.norm(S - P)
        m = before - (before @ u) * u
        m /= np.linalg.norm(m)
        before = found[i] = m * np.cos(phi) + np.cross(u, m) * np.sin(phi)
    return found


@dataclass(frozen=True, eq=False)
class Arc:
    """The part of a band's path that lies on its sphere."""

    Q: Floats
    T: Floats
    n: Floats
    """Unit normal of its plane; the band runs from Q to T right-handed about it."""
    c: Floats
    """The circle's centre."""

    def nearest(self, X: Floats) -> Floats | None:
        """Return the arc's point nearest to X (3,), or None where that is Q or T."""
        q, t = self.Q - self.c, self.T - self.c
        ahead = np.cross(self.n, q)
        arc = np.arctan2(t @ ahead, t @ q) % (2.0 * np.pi)
        x = X - self.c
        x = x - (x @ self.n) * self.n
        size = np.linalg.norm(x)
        if not size > 0.0 or np.arctan2(x @ ahead, x @ q) % (2.0 * np.pi) > arc:
            return None
        return np.asarray(self.c + np.linalg.norm(q) / size * x)


@dataclass(frozen=True, eq=False)
class Route:
    """A band's path, exactly: straight from P to S, or P to Q, an arc, T to S; scapula frame, m."""

    P: Floats
    S: Floats
    arc: Arc | None

    def nearest(self, X: Floats) -> tuple[float, Floats]:
        """Return the distance, m, of a point X (3,) from the path, and the path's nearest point."""
        if self.arc is None:
            points = [_on_segment(X, self.P, self.S)]
        else:
            points = [_on_segment(X, self.P, self.arc.Q), _on_segment(X, self.arc.T, self.S)]
            on_arc = self.arc.nearest(X)
            points += [] if on_arc is None else [on_arc]
        distances = [float(np.linalg.norm(X - point)) for point in points]
        least = int(np.argmin(distances))
        return distances[least], points[least]


def routes(state: MuscleState) -> list[Route]:
    """Return the n bands' paths at a solved pose (right shoulder)."""
    found = []
    parts = zip(state.paths(2), state.wrap, normals(state), state.sphere_centres, strict=True)
    for path, wrap, n, C in parts:
        arc = None
        if wrap == WrapState.WRAPPED:
            arc = Arc(path[1], path[2], n, C - ((C - path[0]) @ n) * n)
        found.append(Route(path[0], path[-1], arc))
    return found


def _on_segment(X: Floats, A: Floats, B: Floats) -> Floats:
    """Return the point nearest to X on the straight line from A to B."""
    along = B - A
    share = float((X - A) @ along) / max(float(along @ along), 1e-300)
    return np.asarray(A + min(max(share, 0.0), 1.0) * along)
