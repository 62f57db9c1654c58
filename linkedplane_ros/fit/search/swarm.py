# SPDX-License-Identifier: Apache-2.0
"""A particle swarm in the unit box, by pymoo, whose whole state can be saved.

pymoo's PSO has its own generator of random numbers: with the state below restored, the swarm
continues to the bit as if it had never been stopped.
"""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from typing import Any

import numpy as np

from ...errors import LinkedPlaneError
from ...libraries import advise_install
from ...types import Floats

NEEDED = ('pymoo', 'scipy', 'matplotlib')
INSTALL = f'a fit needs pymoo, SciPy and matplotlib: {advise_install(*NEEDED)}'
ADAPTED = ('w', 'c1', 'c2')  # the swarm's inertia and pulls, which it changes as it goes


def require_libraries() -> None:
    """Refuse to fit without the libraries that it needs; LinkedPlaneError says how to get them."""
    if not all(map(find_spec, NEEDED)):
        raise LinkedPlaneError(INSTALL)


class Swarm:
    """Particles that look for the least value of a function of p numbers from 0 to 1."""

    def __init__(self, first: Floats, seed: int) -> None:
        """Start with the particles (k, p), k at least 2."""
        require_libraries()
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')  # of its own imports
            from pymoo.algorithms.soo.nonconvex.pso import PSO
            from pymoo.config import Config
            from pymoo.core.problem import Problem
            from pymoo.core.termination import NoTermination

        Config.warnings['not_compiled'] = False
        count = first.shape[1]
        self.problem = Problem(n_var=count, n_obj=1, xl=np.zeros(count), xu=np.ones(count))
        self.algorithm = PSO(pop_size=len(first), sampling=first, seed=seed)
        self.algorithm.setup(self.problem, termination=NoTermination())
        self._asked: Any = None

    def next_particles(self) -> Floats:
        """Return the particles of the next generation, (k, p)."""
        self._asked = self.algorithm.ask()
        return np.array(self._asked.get('X'), dtype=np.float64)

    def take_values(self, values: Floats) -> None:
        """Take the function's values (k,) at these particles; they move on."""
        self.algorithm.tell(infills=self._valued(self._asked, values))

    @property
    def best_particle(self) -> tuple[Floats, float]:
        """The best particle (p,) so far, and the value there."""
        best = self.algorithm.opt[0]
        return np.array(best.X, dtype=np.float64), float(best.F[0])

    def state(self) -> dict[str, Any]:
        """Return all that the swarm needs to continue, in types that JSON has."""
        one = self.algorithm
        return {
            'particles': one.particles.get('X').tolist(),
            'velocities': one.particles.get('V').tolist(),
            'bests': one.pop.get('X').tolist(),
            'values': one.pop.get('F')[:, 0].tolist(),
            'adapted': [float(getattr(one, name)) for name in ADAPTED],
            'generation': int(one.n_iter),
            'random': one.random_state.bit_generator.state,
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Swarm:
        """Return the swarm that had this state."""
        from pymoo.core.population import Population
        from pymoo.util.optimum import filter_optimum

        bests, values = np.array(state['bests']), np.array(state['values'])
        swarm = cls(bests, 0)
        one = swarm.algorithm
        one.start_time, one.is_initialized, one.n_iter = 0.0, True, state['generation']
        one.particles = Population.new(
            X=np.array(state['particles']), V=np.array(state['velocities'])
        )
        one.pop = swarm._valued(Population.new(X=bests), values)
        one.opt = filter_optimum(one.pop, least_infeasible=True)
        for name, value in zip(ADAPTED, state['adapted'], strict=True):
            setattr(one, name, value)
        one.random_state.bit_generator.state = state['random']
        return swarm

    def _valued(self, particles: Any, values: Floats) -> Any:
        from pymoo.core.evaluator import Evaluator
        from pymoo.problems.static import StaticProblem

        static = StaticProblem(self.problem, F=values[:, np.newaxis])
        return Evaluator().eval(static, particles)


def scatter_particles(start: Floats, count: int, width: float, seed: tuple[int, ...]) -> Floats:
    """Return particles (count, p): the start (p,), and others at random up to `width` from it."""
    random = np.random.default_rng(seed)
    low, high = np.maximum(start - width, 0.0), np.minimum(start + width, 1.0)
    particles = low + (high - low) * random.random((count, len(start)))
    particles[0] = start
    return particles
