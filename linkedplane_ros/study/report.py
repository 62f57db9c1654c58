"""A study's folder: report.md for reviewers, tables as CSV, figures as PNG.

CHAPTERS is the one place where a chapter is added: a function from the subject to its title, text,
tables and pictures.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from inspect import cleandoc
from pathlib import Path

from .. import __version__
from ..errors import RecordingError
from ..files import remove_path
from .chapters import experiments as experiments_chapter
from .chapters import fidelity as fidelity_chapter
from .chapters import interference as interference_chapter
from .chapters import model as model_chapter
from .chapters import rivals as rivals_chapter
from .chapters.parts import Chapter, Part, Picture, Table
from .pictures.figures import drawing
from .subject import Subject

CHAPTERS: Sequence[Callable[[Subject], Chapter]] = (
    model_chapter.chapter,
    experiments_chapter.chapter,
    interference_chapter.chapter,
    fidelity_chapter.chapter,
    rivals_chapter.chapter,
)

REPORT = 'report.md'
TITLE = '# Study of '  # begins every report
PATTERNS = (REPORT, 'tables/*.csv', 'figures/*.png', 'figures/*.gif')  # what a study writes
DPI = 200  # of the figures


def write(subject: Subject, folder: Path, force: bool = False, animated: bool = True) -> None:
    """Write a study into a folder that is empty or not there, or, with force, holds a study.

    Nothing is seen there before all is done. RecordingError if the folder holds anything else, or
    cannot be written.
    """
    refuse(folder, force)
    with filled(folder) as made:
        for sub in ('tables', 'figures'):
            (made / sub).mkdir(parents=True)
        pages = [_chapter(make(subject), made, animated) for make in CHAPTERS]
        text = '\n\n'.join([_head(subject), *pages]) + '\n'
        (made / REPORT).write_text(text, encoding='utf-8')


def refuse(folder: Path, force: bool) -> None:
    """RecordingError if a folder may not be replaced by a study."""
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    if not folder.is_dir():
        raise RecordingError(f'{folder}: a file; a folder expected')
    report = folder / REPORT
    if not (report.is_file() and report.read_bytes().startswith(TITLE.encode())):
        raise RecordingError(f'{folder}: not empty and no study; only a study is replaced')
    if not force:
        raise RecordingError(f'{folder}: holds a study; --force to replace it')
    ours = {path for pattern in PATTERNS for path in folder.glob(pattern)}
    for path in folder.rglob('*'):
        if path not in ours and not (path.is_dir() and path.name in ('tables', 'figures')):
            raise RecordingError(f'{path}: is not of the study that stands there; move it away')


@contextmanager
def filled(folder: Path) -> Iterator[Path]:
    """Give a folder to write into; at the end what is in it replaces what is in `folder`.

    The folder itself stays: it may be a mount, or where somebody stands.
    """
    made, workshop = not folder.exists(), folder / f'.study.{os.getpid()}.part'
    new, old = workshop / 'new', workshop / 'old'
    try:
        if made:
            folder.mkdir()
        new.mkdir(parents=True)
        old.mkdir()
        yield new
        for source, target in ((folder, old), (new, folder)):
            for path in [each for each in source.iterdir() if each != workshop]:
                path.rename(target / path.name)
    except OSError as error:
        raise RecordingError(f'{folder}: not written: {error.strerror or error}') from None
    finally:
        remove_path(workshop)
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def _head(subject: Subject) -> str:
    scaled = '' if subject.scale == 1.0 else f', moment arms x {subject.scale:g}'
    return cleandoc(f"""
        {TITLE}{subject.muscle.name}

        Made by `linkedplane study` of linkedplane_ros {__version__} from the model
        `{subject.model}`{scaled}. It does chapter 5 and appendix E of B. Xu's thesis *A
        Linked-plane Obstacle-set Algorithm for Modeling Broad Muscle Paths: Application to the
        Deltoid Muscle* again, and says where the printed text and its numbers part. Lengths and
        moment arms are in mm, angles in degrees; each table is a CSV file, too. The sources of the
        figures of others stand in the package's `literature/README.md`.
    """)


def _chapter(chapter: Chapter, folder: Path, animated: bool) -> str:
    """Write a chapter's files; return its text."""
    written = (_part(part, folder, animated) for part in chapter.parts)
    return '\n\n'.join([f'## {chapter.title}', *filter(None, written)])


def _part(part: Part, folder: Path, animated: bool) -> str:
    if isinstance(part, str):
        return cleandoc(part)
    if isinstance(part, Table):
        file = f'tables/{part.name}.csv'
        (folder / file).write_text(part.csv(), encoding='utf-8')
        if not part.shown:
            return f'{part.title}: [{file}]({file}).'
        return f'{part.title} ([{file}]({file})):\n\n{part.markdown()}'
    if isinstance(part, Picture):
        file = f'figures/{part.name}.png'
        with drawing():
            part.draw().savefig(folder / file, dpi=DPI)
    else:
        if not animated:
            return ''
        file = f'figures/{part.name}.gif'
        part.write(folder / file)
    caption = ' '.join(part.caption.split())
    return f'![{part.name}]({file})\n\n*{caption}*'
