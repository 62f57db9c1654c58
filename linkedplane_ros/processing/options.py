# SPDX-License-Identifier: Apache-2.0
"""What a user may ask of the processing of recordings, and which wishes go together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import LinkedPlaneError
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION, JointConvention
from ..joints.frame_names import check_frame_name
from ..skeleton.girdle import Rest
from ..skeleton.skeleton import parse_bone_links


@dataclass(frozen=True, kw_only=True)
class Options:
    """How recordings are processed; the command `process` has an option for each field.

    Raises
    ------
    LinkedPlaneError
        For options that do not go together; the message names them as the command does.
    """

    kind: str | None = None
    """bag, csv or parquet; None: by the ending of the output's name."""
    muscle: str = 'deltoid'
    """A bundled model's name, or the path of a model file."""
    scale: str = '1'
    """The subject's size, as BroadMuscle.scaled takes it."""
    side: str = 'right'
    convention: str = THESIS_CONVENTION.name
    joints: Sequence[str] | None = None
    """The joints or columns of the coordinates; None: of the same names."""
    signs: Sequence[float] | None = None
    """angle = sign * recorded + offset; None: 1 for each."""
    offsets: Sequence[float] | None = None
    """rad; None: 0 for each."""
    degrees: bool | None = None
    """Whether the recorded angles are in degrees; None: as the recording says, else rad."""
    time: str | None = None
    """The column of a table's time; None: one that is called as times usually are."""
    topic: str | None = None
    """The topic of a bag's joint states; None: the usual one, or the only one."""
    input: str | None = None
    """joint_states or tf; None: tf where frames of bones are given."""
    humerus: str | None = None
    """The frame of the humerus, where the angles come from poses; with scapula or thorax."""
    scapula: str | None = None
    clavicle: str | None = None
    thorax: str | None = None
    bone_links: Sequence[str] | None = None
    """BONE:=LINK, the link in the skeleton, or with poses the frame, of a bone of another name."""
    skeleton: str | None = None
    """A bundled skeleton's name, or the path of a .urdf; None: a ball joint."""
    joint_names: Sequence[str] | None = None
    """JOINT:=NAME, under which a joint of the skeleton is recorded."""
    rest_frames: Sequence[str] | None = None
    """Where the bones' frames stand at rest, as `rest_options.read_rest_frames` reads it; None:
    those of the skeleton, else as `bone_frames.DOUBTED` says."""
    rhythm: str | None = None
    """How the scapula follows, with thorax: a name of RHYTHMS, or the ratio of glenohumeral to
    scapulothoracic elevation; None: constant_ratio, 2."""
    rest: Sequence[float | str] | None = None
    """rad, the scapula's three angles at rest (`GIRDLE`), and if known the humerus' plane of
    elevation and elevation there; the word still, alone or after the scapula's three: as in the
    recording's first still second; None: as the rhythm has them."""
    frame_axes: str | None = None
    """The axes of the bones' frames, model or isb; None: model."""
    frame_id: str = 'scapula'
    """The frame of the outputs."""
    rate: float | None = None
    """Hz, to resample at; None: as recorded."""
    lowpass: float | None = None
    """Hz, the cutoff of a filter; None: no filter."""
    differentiate: bool = False
    """Whether the velocities are differences in time, even where some were recorded."""
    markers: bool = True
    """Whether a bag gets the markers, too."""
    plain: bool = False
    """Whether a CSV begins with its header; the facts are in a file beside it."""
    force: bool = False
    """Whether an output that exists is replaced."""

    def __post_init__(self) -> None:
        """Refuse options that cannot be, or do not go together."""
        check_frame_name('--frame-id', self.frame_id)
        self._check_rhythm()
        self._check_poses()
        of_joints = ('joints', 'signs', 'offsets', 'topic', 'degrees', 'time')
        self._check_skeleton()
        given = [name for name in of_joints if getattr(self, name) is not None]
        if self.has_poses and given:
            name = 'radians' if self.degrees is False and given[0] == 'degrees' else given[0]
            raise LinkedPlaneError(f'--{name}: only for joint angles, not for poses (--humerus)')
        if self.bone_links is not None and self.skeleton is None and not self.has_poses:
            raise LinkedPlaneError('--bone-links: only with --skeleton or --input tf')
        if self.joint_names is not None and (self.skeleton is None or self.has_poses):
            raise LinkedPlaneError('--joint-names: only with the joints of a --skeleton')
        parse_bone_links(self.bone_links or ())

    def _check_skeleton(self) -> None:
        given = [name for name in ('joints', 'signs', 'offsets') if getattr(self, name) is not None]
        if self.skeleton is not None and given:
            hint = "the joints are the skeleton's; --joint-names JOINT:=NAME names them otherwise"
            raise LinkedPlaneError(f'--{given[0]}: not with --skeleton: {hint}')

    def _check_rhythm(self) -> None:
        if self.scapula is not None and self.rhythm is not None:
            raise LinkedPlaneError('--rhythm: not with the pose of the scapula (--scapula)')
        if self.skeleton is not None and self.follows:
            line = 'a rhythm stands for the joints of a skeleton; --scapula or no --rhythm expected'
            raise LinkedPlaneError(f'--skeleton: {line}')
        if self.rest is not None and not self.follows:
            raise LinkedPlaneError('--rest: only with a rhythm, against the thorax (--thorax)')
        if self.given_rest is not None and self.rests_still and self.given_rest.humerus:
            raise LinkedPlaneError('--rest: still after 5 numbers; after 3 or alone expected')

    def _check_poses(self) -> None:
        named = self.humerus, self.scapula, self.clavicle, self.thorax
        if '' in named:
            raise LinkedPlaneError('--humerus, --scapula, --clavicle, --thorax: a name expected')
        if self.input is None or self.humerus is not None:
            has_base = self.scapula is not None or self.thorax is not None
            if (self.humerus is not None) != has_base:
                raise LinkedPlaneError('--humerus NAME goes with --scapula NAME or --thorax NAME')
        if self.clavicle is not None and self.scapula is None and self.input is None:
            raise LinkedPlaneError('--clavicle NAME goes with --humerus NAME and --scapula NAME')
        if self.input == 'joint_states' and any(named):
            raise LinkedPlaneError('--input joint_states: joints have no frames (--humerus)')
        for option, value in ('frame-axes', self.frame_axes), ('rest-frames', self.rest_frames):
            if value is not None and not self.has_poses:
                raise LinkedPlaneError(f'--{option}: only for poses (--humerus)')
        smooth = {'rate': self.rate, 'lowpass': self.lowpass, 'differentiate': self.differentiate}
        for option, asked in smooth.items():
            if asked and (self.clavicle is not None or (self.has_poses and self.skeleton)):
                raise LinkedPlaneError(f'--{option}: only for angles, not for poses of more bones')

    @property
    def has_poses(self) -> bool:
        """Whether the motion is poses of bones."""
        return self.input == 'tf' or self.humerus is not None

    @property
    def follows(self) -> bool:
        """Whether the girdle follows the humerus by a rhythm."""
        if self.has_poses and self.input is None:
            return self.scapula is None and self.thorax is not None
        return self.rhythm is not None

    @property
    def links(self) -> dict[str, str]:
        """The links or frames of bones that are not named as they are."""
        return parse_bone_links(self.bone_links or ())

    def list_frames(self, bones: Sequence[str]) -> dict[str, str] | None:
        """Return the frame of each bone, the ground's first; None: joints are recorded.

        Parameters
        ----------
        bones
            The muscle's: the ground first, then those that move.
        """
        if not self.has_poses:
            return None
        named = {
            'thorax': self.thorax,
            'scapula': self.scapula,
            'clavicle': self.clavicle,
            'humerus': self.humerus,
        }
        given = {bone: name for bone, name in named.items() if name is not None}
        if self.input == 'tf':
            needed = ('thorax', 'humerus') if self.follows else (*bones, *self.links)
            links = {bone: self.links.get(bone, bone) for bone in needed}
            if self.skeleton is not None:  # LINK@PLACE says where the bone stands in it
                links = {bone: link.partition('@')[0] for bone, link in links.items()}
            given = {**links, **given}
        elif len(given) == 2 and not self.follows and self.humerus is not None:
            return {bones[0]: self.scapula or '', bones[-1]: self.humerus}
        return given

    @property
    def joint_convention(self) -> JointConvention:
        """The convention itself."""
        return JOINT_CONVENTIONS[self.convention]

    @property
    def rests_still(self) -> bool:
        """Whether the humerus' rest is that of the recording's first still second."""
        return bool(self.rest) and list(self.rest or ())[-1] == 'still'

    @property
    def given_rest(self) -> Rest | None:
        """The rest that the numbers say; None: there are none."""
        if self.rest is None or list(self.rest) == ['still']:
            return None
        return Rest.from_numbers(self.rest[:-1] if self.rests_still else self.rest, '--rest')
