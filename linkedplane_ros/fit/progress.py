"""How far a fit is, for a person who looks on."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .fitting import Plan, Progress


@contextmanager
def bar(plan: Plan) -> Iterator[Callable[[Progress], None]]:
    """Show the generations done and the best criterion while in the block, if a person looks on."""
    try:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Bar
    except ImportError:
        yield lambda progress: None
        return
    columns = (
        TextColumn('fitting, round {task.fields[round]}'),
        BarColumn(),
        TextColumn('{task.completed:.0f} of {task.total:.0f} generations'),
        TextColumn('best {task.fields[best]} mm²'),
        TimeElapsedColumn(),
    )
    with Bar(*columns, transient=True, disable=not sys.stderr.isatty(),
                  console=Console(stderr=True)) as shown:  # fmt: skip
        total = plan.rounds * plan.generations
        number = shown.add_task('', total=total, round=1, best='-')

        def tell(progress: Progress) -> None:
            shown.update(
                number,
                completed=progress.round * plan.generations + progress.generation,
                round=min(progress.round + 1, plan.rounds),
                best=f'{progress.best:,.2f}',
            )

        yield tell
