# SPDX-License-Identifier: Apache-2.0
"""The files of a fit, written all or none: model, report, pictures; and its checkpoint."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from ..errors import LinkedPlaneError
from ..files import synchronise
from .figure import draw_fit, draw_trade_off
from .report import FinishedFit, report_text


class Files:
    """The files that a fit writes, all in one folder.

    Parameters
    ----------
    model
        The fitted model, .yaml; the others have its name with other endings.
    tightens
        Whether the plan has depths to tighten by, and so a picture of the trade-off.

    Raises
    ------
    LinkedPlaneError
        For a model that does not end in .yaml.

    """

    def __init__(self, model: Path, tightens: bool) -> None:
        """Name the files."""
        if model.suffix not in ('.yaml', '.yml'):
            raise LinkedPlaneError(f'{model}: a model file ends in .yaml')
        self.model = model
        self.checkpoint, self.report = model.with_suffix('.checkpoint'), model.with_suffix('.md')
        self.pictures = {'Measured and modelled': model.with_suffix('.png')}
        if tightens:
            trade_off = model.with_name(f'{model.stem}_trade_off.png')
            self.pictures['Deviation and interference'] = trade_off

    @property
    def results(self) -> tuple[Path, ...]:
        """The files that a fit leaves."""
        return self.model, self.report, *self.pictures.values()

    def check_overwriting(self, data: Path, force: bool) -> None:
        """Refuse to overwrite the data, or a result without `force`, or a folder."""
        if not self.model.parent.is_dir():
            raise LinkedPlaneError(f'{self.model}: no folder {self.model.parent} to write into')
        present = [path for path in self.results if path.exists()]
        reasons = (overwriting_fault(path, data, force) for path in present)
        fault = next(filter(None, reasons), '')
        if fault:
            raise LinkedPlaneError(fault)

    def write_outcome(self, outcome: FinishedFit) -> None:
        """Write all results; each takes its place when the last is complete.

        LinkedPlaneError where one cannot be written; none is replaced then.
        """
        try:
            with tempfile.TemporaryDirectory(prefix='.fit.', dir=self.model.parent) as folder:
                beside = [Path(folder) / path.name for path in self.results]
                model, report, picture, *trade_off = beside
                outcome.after.to_yaml(model)
                draw_fit(outcome, picture)
                for file in trade_off:
                    draw_trade_off(outcome, file)
                names = {title: path.name for title, path in self.pictures.items()}
                report.write_text(report_text(outcome, names), encoding='utf-8')
                synchronise(Path(folder))
                for file, path in zip(beside, self.results, strict=True):
                    os.replace(file, path)
        except OSError as error:
            raise LinkedPlaneError(
                f'{self.model}: not written: {error.strerror or error}'
            ) from None


def overwriting_fault(path: Path, data: Path, force: bool) -> str:
    """Return why a path that exists may not be replaced by a result; empty if it may."""
    if path.resolve() == data.resolve():
        return f'{path}: holds the measurements; another name expected'
    if path.is_dir():
        return f'{path}: is a folder; the name of a file expected'
    return '' if force else f'{path}: exists already; --force replaces it'
