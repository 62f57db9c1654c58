"""The files of a fit, written whole or not at all: model, report, pictures, and its checkpoint."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .figure import draw, draw_trade_off
from .report import Outcome, markdown


class Files:
    """Where a fit writes to, all beside each other."""

    def __init__(self, model: Path, tightens: bool) -> None:
        """Name them; ValueError for a model that does not end in .yaml."""
        if model.suffix not in ('.yaml', '.yml'):
            raise ValueError(f'{model}: a model file ends in .yaml')
        self.model = model
        self.checkpoint, self.report = model.with_suffix('.checkpoint'), model.with_suffix('.md')
        self.pictures = {'Measured and modelled': model.with_suffix('.png')}
        if tightens:
            trade_off = model.with_name(f'{model.stem}_trade_off.png')
            self.pictures['Deviation and interference'] = trade_off

    @property
    def results(self) -> tuple[Path, ...]:
        """What a fit leaves."""
        return self.model, self.report, *self.pictures.values()

    def check(self, data: Path, force: bool) -> None:
        """ValueError for what would be lost, and for a place that cannot be written to."""
        if not self.model.parent.is_dir():
            raise ValueError(f'{self.model}: no folder {self.model.parent} to write into')
        for path in self.results:
            if path.exists() and path.resolve() == data.resolve():
                raise ValueError(f'{path}: holds the measurements; another name expected')
            if path.is_dir():
                raise ValueError(f'{path}: a folder; a file is to be written there')
            if path.exists() and not force:
                raise ValueError(f'{path}: is there already; --force replaces it')

    def write(self, outcome: Outcome) -> None:
        """Write all; each takes its place when the last is complete. ValueError if one cannot."""
        try:
            with tempfile.TemporaryDirectory(prefix='.fit.', dir=self.model.parent) as folder:
                beside = [Path(folder) / path.name for path in self.results]
                model, report, picture, *trade_off = beside
                outcome.after.to_yaml(model)
                draw(outcome, picture)
                for file in trade_off:
                    draw_trade_off(outcome, file)
                names = {title: path.name for title, path in self.pictures.items()}
                report.write_text(markdown(outcome, names), encoding='utf-8')
                for file, path in zip(beside, self.results, strict=True):
                    os.replace(file, path)
        except OSError as error:
            raise ValueError(f'{self.model}: not written: {error.strerror or error}') from None
