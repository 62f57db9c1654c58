# SPDX-License-Identifier: Apache-2.0
"""A study's folder: report.md for reviewers, tables as CSV, figures as PNG.

CHAPTERS is the one place where a chapter is added: a function from the subject to its title, text,
tables and pictures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from inspect import cleandoc
from pathlib import Path

from .. import __version__
from ..drawing.figure_files import house_style
from ..errors import RecordingError
from ..files import claim_output, synchronise, workshop_of
from .chapters.experiments import experiments_chapter
from .chapters.fidelity import fidelity_chapter
from .chapters.interference import interference_chapter
from .chapters.model import model_chapter
from .chapters.parts import Chapter, Part, PicturePart, TablePart
from .chapters.rivals import rivals_chapter
from .subject import Subject

CHAPTERS: Sequence[Callable[[Subject], Chapter]] = (
    model_chapter,
    experiments_chapter,
    interference_chapter,
    fidelity_chapter,
    rivals_chapter,
)

REPORT, STUDY = 'report.md', 'study'
TITLE = '# Study of '  # begins every report
FOLDERS = ('tables', 'figures')
PATTERNS = (REPORT, 'tables/*.csv', 'figures/*.png', 'figures/*.gif')  # what a study writes
DPI = 200  # of the figures


def write_study(subject: Subject, folder: Path, force: bool = False, animated: bool = True) -> None:
    """Write a study; the folder gets its content when all is complete.

    Parameters
    ----------
    subject
        The muscle under study.
    folder
        Where: empty, or not there yet.
    force
        Whether a study that the folder holds is replaced.
    animated
        Whether flexion is drawn as a GIF.

    Raises
    ------
    RecordingError
        If the folder holds anything else, or cannot be written.
    """
    check_folder(folder, force)
    with replace_content(folder) as made:
        for sub in FOLDERS:
            (made / sub).mkdir(parents=True)
        pages = [_chapter(make(subject), made, animated) for make in CHAPTERS]
        text = '\n\n'.join([_head(subject), *pages]) + '\n'
        (made / REPORT).write_text(text, encoding='utf-8')


def check_folder(folder: Path, force: bool) -> None:
    """Raise RecordingError if a folder's content may not be replaced by a study."""
    workshop = workshop_of(folder / STUDY)  # maybe of a run that was killed
    if not folder.exists() or (folder.is_dir() and set(folder.iterdir()) <= {workshop}):
        return
    if not folder.is_dir():
        raise RecordingError(f'{folder}: a file; a folder expected')
    report = folder / REPORT
    if not (report.is_file() and report.read_bytes().startswith(TITLE.encode())):
        raise RecordingError(f'{folder}: not empty and not a study; only a study is replaced')
    if not force:
        raise RecordingError(f'{folder}: holds a study; --force to replace it')
    ours = {path for pattern in PATTERNS for path in folder.glob(pattern)}
    ours |= {workshop, *workshop.rglob('*')}
    others = (path for path in folder.rglob('*') if path not in ours)
    foreign = next((each for each in others if not (each.is_dir() and each.name in FOLDERS)), None)
    if foreign is not None:
        raise RecordingError(f'{foreign}: is not a file of the study in this folder; move it away')


@contextmanager
def replace_content(folder: Path) -> Iterator[Path]:
    """Give a folder to write into; at the end its content replaces that of `folder`.

    The folder itself stays: it may be a mount point, or a shell's current folder.
    """
    made = not folder.exists()
    try:
        if made:
            folder.mkdir()
        with claim_output(folder / STUDY, RecordingError) as workshop:
            new, old = workshop / 'new', workshop / 'old'
            new.mkdir()
            old.mkdir()
            yield new
            synchronise(new)
            for source, target in ((folder, old), (new, folder)):
                for path in [each for each in source.iterdir() if each != workshop]:
                    path.rename(target / path.name)
    except OSError as error:
        raise RecordingError(f'{folder}: not written: {error.strerror or error}') from None
    finally:
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def _head(subject: Subject) -> str:
    scaled = '' if subject.scale == 1.0 else f', moment arms x {subject.scale:g}'
    return cleandoc(f"""
        {TITLE}{subject.muscle.name}

        Made by `linkedplane study` of linkedplane_ros {__version__} from the model
        `{subject.model}`{scaled}. It does chapter 5 and appendix E of B. Xu's thesis *A
        Linked-plane Obstacle-set Algorithm for Modeling Broad Muscle Paths: Application to the
        Deltoid Muscle* again, and says where the printed text and its numbers differ. Lengths and
        moment arms are in mm, angles in degrees; each table is a CSV file, too. The sources of the
        numbers of others are in the package's `literature/README.md`.
    """)


def _chapter(chapter: Chapter, folder: Path, animated: bool) -> str:
    """Write a chapter's files; return its text."""
    written = (_part(part, folder, animated) for part in chapter.parts)
    return '\n\n'.join([f'## {chapter.title}', *filter(None, written)])


def _part(part: Part, folder: Path, animated: bool) -> str:
    if isinstance(part, str):
        return cleandoc(part)
    if isinstance(part, TablePart):
        file = f'tables/{part.name}.csv'
        (folder / file).write_text(part.csv(), encoding='utf-8')
        if not part.visible:
            return f'{part.title}: [{file}]({file}).'
        return f'{part.title} ([{file}]({file})):\n\n{part.markdown()}'
    if isinstance(part, PicturePart):
        file = f'figures/{part.name}.png'
        with house_style():
            part.draw().savefig(folder / file, dpi=DPI)
    else:
        if not animated:
            return ''
        file = f'figures/{part.name}.gif'
        part.write(folder / file)
    caption = ' '.join(part.caption.split())
    return f'![{part.name}]({file})\n\n*{caption}*'
