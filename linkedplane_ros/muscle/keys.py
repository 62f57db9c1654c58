# SPDX-License-Identifier: Apache-2.0
"""The keys that a model file is checked against, by the reader and by the JSON Schema.

The table of the documentation comes from them, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from .parts import METRES, RADIANS
from .yaml_mapping import YamlMapping

FORMAT = 'linkedplane_ros/broad_muscle'
VERSIONS = (1, 2)


@dataclass(frozen=True)
class Key:
    """A key of a model file."""

    path: str
    """With dots; NAME is a name of the user's own, QUANTITY and POINTS are what has these types."""
    type: str
    """One of TYPES; '' for a key with other keys below it."""
    meaning: str
    """In Markdown."""
    unit: str = ''
    """The key that states it."""
    frame: str = ''
    """What points are measured in."""
    choices: tuple[str, ...] = ()
    """The words that may be there."""
    required: bool = True
    field: str = ''
    """Of a BroadMuscle, where that names it otherwise."""
    positive: bool = False
    """Whether its numbers are above zero."""


TYPES = {
    'format': f'`{FORMAT}`',
    'version': ' or '.join(f'`{version}`' for version in VERSIONS),
    'word': 'a word',
    'words': 'a word, or a list with one for each band',
    'name': 'a letter, then letters, digits and `_`',
    'names': 'a list of names, without commas',
    'text': 'text',
    'number': 'a number',
    'numbers': 'a list with a number for each band',
    'places': 'as below, or a list with a number for each band',
    'interval': '[lowest, highest]',
    'point': '[x, y, z]',
    'point_list': 'a list with a point for each band',
    'quantity': 'a quantity',
    'points': 'points',
}
"""What may be under a key, as the documentation calls it."""

GROUND, HUMERUS = 'ground', 'humerus'
LENGTH, ANGLE = 'units.length', 'units.angle'

KEYS = (
    Key('format', 'format', 'What kind of file this is.'),
    Key(
        'version',
        'version',
        'The version of the format. A program refuses a version that it does not know.',
    ),
    Key('name', 'name', "The muscle's name: the node's topics begin with it."),
    Key('source', 'text', 'Where the numbers come from: a publication, a measurement.'),
    Key('licence', 'text', 'What others may do with the file.', required=False),
    Key('units', '', 'The units of all numbers of the file.'),
    Key('units.length', 'word', 'The unit of points and radii.', choices=tuple(METRES)),
    Key(
        'units.angle',
        'word',
        'The unit of plane angles and of the range of motion.',
        choices=tuple(RADIANS),
    ),
    Key('bands', '', 'The bands, in the order in which their planes are linked.'),
    Key('bands.names', 'names', 'A name for each band; any number of them.', field='band_names'),
    Key(
        'bands.s',
        'places',
        "s: where each band lies on the muscle's breadth. The polynomials are in s; not needed "
        'where there are none.',
        required=False,
    ),
    Key(
        'bands.s.first',
        'number',
        's of the first band; the others follow at even distances.',
    ),
    Key('bands.s.last', 'number', 's of the last band.'),
    Key(
        'heads',
        '',
        'The parts of the muscle by their names; together they have every band once. Without this '
        'key, the muscle is its own only head.',
        required=False,
    ),
    Key('heads.NAME.bands', 'names', "The names of the head's bands."),
    Key(
        'heads.NAME.represented_by',
        'text',
        'The one of these bands that represents the head in comparisons.',
    ),
    Key(
        'bones',
        '',
        'The bones, and which of them the points belong to. Needed in version 2, refused in '
        'version 1: there the bones are `scapula` and `humerus`, and all else has its default.',
        required=False,
    ),
    Key(
        'bones.names',
        'names',
        'The ground bone first, then those that move. The last one is what a rotation alone poses, '
        "about the ground's origin, as the joint angles do. At rest all frames coincide.",
    ),
    Key(
        'bones.origin', 'words', 'The bones of the origins; by default the ground.', required=False
    ),
    Key(
        'bones.insertion',
        'words',
        'The bones of the insertions; by default the last bone.',
        required=False,
    ),
    Key(
        'bones.ground_point',
        'word',
        'The bone of `sphere.ground_point`; by default the ground.',
        required=False,
    ),
    Key(
        'bones.humeral_point',
        'word',
        'The bone of `sphere.humeral_point`; by default the last bone.',
        required=False,
    ),
    Key(
        'bones.reference_normal',
        'word',
        'The bone that N turns with; by default the ground.',
        required=False,
    ),
    Key('origin', 'points', 'Where the bands arise.', LENGTH, GROUND, field='origins'),
    Key('insertion', 'points', 'Where the bands end.', LENGTH, HUMERUS, field='insertions'),
    Key(
        'sphere',
        '',
        'The obstacle spheres that the bands wrap: one for each band, or the same for all.',
    ),
    Key(
        'sphere.frame',
        'words',
        'What the spheres move with: the scapula (`ground`), the `humerus` (or another bone that '
        "moves), or a `moving` frame of each band's own (below).",
        field='sphere_frame',
    ),
    Key(
        'sphere.centre',
        'points',
        'The centres of the spheres. Bands with the same centre and radius share one sphere, '
        'unless it moves with the band.',
        LENGTH,
        '`sphere.frame`',
        field='sphere_centres',
    ),
    Key(
        'sphere.radius',
        'quantity',
        'The radii of the spheres, above zero.',
        LENGTH,
        field='sphere_radii',
        positive=True,
    ),
    Key(
        'sphere.ground_point',
        'point',
        'SC: z axes of moving frames are normal to the plane through the origin, `humeral_point` '
        'and this point. Needed with a moving frame, refused without one.',
        LENGTH,
        GROUND,
        required=False,
        field='ground_point',
    ),
    Key(
        'sphere.humeral_point',
        'point',
        "HM: x axes of moving frames point from the band's origin to it. Needed with a moving "
        'frame, refused without one.',
        LENGTH,
        HUMERUS,
        required=False,
        field='humeral_point',
    ),
    Key(
        'plane_angle',
        'quantity',
        "phi: the angle of each band's plane from that of the band before it, right-handed about "
        "the line from origin to insertion. The first band's own is not used: the solver finds it "
        '(theta).',
        ANGLE,
        field='plane_angles',
    ),
    Key(
        'reference_normal',
        'point',
        'N, of any length above zero: theta is measured from the plane with this normal. Best near '
        "the first band's plane; never along the first band.",
        '',
        GROUND,
    ),
    Key('interference_spheres', '', 'Bone that no band should enter, by its name.', required=False),
    Key('interference_spheres.NAME.centre', 'point', 'The centre.', LENGTH, GROUND),
    Key(
        'interference_spheres.NAME.radius',
        'number',
        'The radius, above zero.',
        LENGTH,
        positive=True,
    ),
    Key(
        'interference_spheres.NAME.bone',
        'word',
        'The bone that the sphere is on; by default the ground. Version 2 only.',
        required=False,
    ),
    Key(
        'landmarks',
        '',
        'Places on the bones that can be found on a subject, by their names: what a subject is '
        'measured by to scale the model. `joint_centre`, the origin of both bones, is always '
        'there.',
        required=False,
    ),
    Key(
        'landmarks.NAME.bone', 'word', 'The bone that the landmark is on: `scapula`, `humerus`, ...'
    ),
    Key('landmarks.NAME.at', 'point', 'The place.', LENGTH, "its bone's"),
    Key(
        'range_of_motion',
        '',
        'The motion that the model was fitted in, or looked at: three angles, each about an axis '
        'that the ones before have turned.',
        required=False,
    ),
    Key('range_of_motion.flexion', 'interval', 'About x.', ANGLE),
    Key('range_of_motion.abduction', 'interval', 'About -y.', ANGLE),
    Key(
        'range_of_motion.rotation',
        'interval',
        'About z of the humerus; internal rotation is positive.',
        ANGLE,
    ),
    Key('QUANTITY.list', 'numbers', 'A quantity, band by band.'),
    Key('POINTS.x', 'quantity', 'The x coordinate of points.'),
    Key('POINTS.y', 'quantity', 'The y coordinate.'),
    Key('POINTS.z', 'quantity', 'The z coordinate.'),
    Key(
        'POINTS.list',
        'point_list',
        'Points, band by band, in place of `x`, `y` and `z`.',
        required=False,
    ),
)

KEYS_OF_FIELDS = {key.field: key.path for key in KEYS if key.field} | dict.fromkeys(
    ('interference_names', 'interference_centres', 'interference_radii'), 'interference_spheres'
)
"""Where a file has the fields of a BroadMuscle that it names otherwise."""


def keys_below(path: str) -> Iterator[tuple[str, Key]]:
    """Yield the last names of the keys directly below a path ('': of the file), with the keys."""
    for key in KEYS:
        parent, _, name = key.path.rpartition('.')
        if parent == path:
            yield name, key


def known_keys(path: str) -> tuple[list[str], list[str]]:
    """Return the names of the keys below a path: those needed, and those that may be there."""
    named = list(keys_below(path))
    needed = [name for name, key in named if key.required]
    return needed, [name for name, key in named if not key.required]


def check_keys(mapping: YamlMapping, path: str) -> None:
    """Refuse what a mapping of a model file lacks of the keys below a path, or has besides them."""
    mapping.check_keys(*known_keys(path))
