# SPDX-License-Identifier: Apache-2.0
"""What a user may ask of the processing of recordings, and which wishes go together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import LinkedPlaneError
from ..joints.conventions import JOINT_CONVENTIONS, THESIS_CONVENTION, JointConvention
from ..joints.frame_names import check_frame_name
from ..joints.joint_state import JointMap
from ..recordings.bone_frames import BoneFrames
from ..skeleton.girdle import Rest
from ..skeleton.rhythms import rhythm_from


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
    """The joints or columns of the convention's coordinates; None: of the same names."""
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
    humerus: str | None = None
    """The frame of the humerus, where the angles come from poses; with scapula or thorax."""
    scapula: str | None = None
    thorax: str | None = None
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
        has_base = self.scapula is not None or self.thorax is not None
        if self.rhythm is not None and self.thorax is None:
            raise LinkedPlaneError('--rhythm: only for angles against the thorax (--thorax)')
        if self.rest is not None and self.thorax is None:
            raise LinkedPlaneError('--rest: only with a rhythm, against the thorax (--thorax)')
        if self.given_rest is not None and self.rests_still and self.given_rest.humerus:
            raise LinkedPlaneError('--rest: still after 5 numbers; after 3 or alone expected')
        if (self.humerus is not None) != has_base:
            raise LinkedPlaneError('--humerus NAME goes with --scapula NAME or --thorax NAME')
        if '' in (self.humerus, self.scapula, self.thorax):
            raise LinkedPlaneError('--humerus, --scapula, --thorax: a name expected')
        if self.humerus is None and self.frame_axes is not None:
            raise LinkedPlaneError('--frame-axes: only for poses (--humerus)')
        of_joints = ('joints', 'signs', 'offsets', 'topic', 'degrees', 'time')
        given = [name for name in of_joints if getattr(self, name) is not None]
        if self.humerus is not None and given:
            name = 'radians' if self.degrees is False and given[0] == 'degrees' else given[0]
            raise LinkedPlaneError(f'--{name}: only for joint angles, not for poses (--humerus)')

    @property
    def joint_convention(self) -> JointConvention:
        """The convention itself."""
        return JOINT_CONVENTIONS[self.convention]

    @property
    def joint_map(self) -> JointMap:
        """How the convention's coordinates follow from what was recorded."""
        a, b, c = self.joints or self.joint_convention.coordinates
        i, j, k = self.signs or (1.0, 1.0, 1.0)
        x, y, z = self.offsets or (0.0, 0.0, 0.0)
        return JointMap((a, b, c), (i, j, k), (x, y, z))

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

    @property
    def bones(self) -> BoneFrames | None:
        """The frames to take the angles from; None: they are joint angles."""
        if self.humerus is None:
            return None
        axes = self.frame_axes or 'model'
        if self.scapula is not None:
            return BoneFrames({'scapula': self.scapula, 'humerus': self.humerus}, axes)
        rhythm = rhythm_from(self.rhythm or 'constant_ratio')
        names = {'thorax': self.thorax or '', 'humerus': self.humerus}
        return BoneFrames(names, axes, rhythm, self.given_rest)
