"""Where things are, in double.

Blender composes the transforms of parents and instances in single precision: 100 km from the origin a child's place is
rounded to 8 mm, however finely its own location and its parent's are given. These are composed here once more.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

FAR = 1024.0  # [m] from the origin; nearer, single precision is off by less than a tenth of a millimetre
ROUNDING = 2.0**-24
NO_INDEX = 2**31 - 1  # where Blender's persistent_id has no more entries


class Place(NamedTuple):
    """A transform and how it came about."""

    matrix: np.ndarray  # (4, 4) f64
    size: np.ndarray  # (4, 4) f64, the same product of absolute values: what rounding errors are a share of
    steps: int  # matrices multiplied


class Places:
    """World matrices of one evaluated scene; each parent's is composed once."""

    def __init__(self) -> None:
        self._known: dict[int, Place] = {}  # address of the object -> its place

    def of(self, ob: Any) -> np.ndarray:
        """Local to world of an evaluated object, (4, 4) f64."""
        return self._place(ob).matrix

    def of_instance(self, item: Any) -> np.ndarray:
        """The same of an entry of ``depsgraph.object_instances``, which may be an instance."""
        single = _as_double(item.matrix_world)
        if not _far(single):  # the usual answer costs next to nothing: there may be 100 000 entries
            return single
        if not item.is_instance:
            return self.of(item.object)
        instancer = item.parent
        direct = instancer.instance_type == "COLLECTION" and item.persistent_id[1] == NO_INDEX
        if not direct or instancer.instance_collection is None:
            return single
        shift = np.eye(4)
        shift[:3, 3] = -np.array(instancer.instance_collection.instance_offset, np.float64)
        return _product((self._place(instancer), _given(shift), self._place(item.instance_object)), single).matrix

    def _place(self, ob: Any) -> Place:
        """Composed from the parent's where that is all that Blender did, else as Blender has it."""
        key = ob.as_pointer()
        if key not in self._known:
            place = _given(_as_double(ob.matrix_world))
            if _far(place.matrix) and _is_plain_child(ob):
                own = (_given(_as_double(matrix)) for matrix in (ob.matrix_parent_inverse, ob.matrix_basis))
                place = _product((self._place(ob.parent), *own), place.matrix)
            self._known[key] = place
        return self._known[key]


def _as_double(matrix: Any) -> np.ndarray:
    """A ``mathutils.Matrix`` as (4, 4) f64."""
    return np.array(matrix, np.float64)


def _far(matrix: np.ndarray) -> bool:
    """Whether it leads far from the origin."""
    return max(abs(matrix[0, 3]), abs(matrix[1, 3]), abs(matrix[2, 3])) >= FAR


def _given(matrix: np.ndarray) -> Place:
    """A transform that is known as it is."""
    return Place(matrix, np.abs(matrix), 1)


def _is_plain_child(ob: Any) -> bool:
    """Whether nothing but its own transform and its parent's place an object."""
    parent = ob.parent
    if parent is None or ob.parent_type != "OBJECT" or len(ob.constraints) or ob.rigid_body is not None:
        return False
    return not (parent.type == "CURVE" and parent.data.use_path)


def _product(parts: tuple[Place, ...], single: np.ndarray) -> Place:
    """The product in double; Blender's own, (4, 4) `single`, where rounding does not explain the difference."""
    matrix, size = parts[0].matrix, parts[0].size
    for part in parts[1:]:
        matrix, size = matrix @ part.matrix, size @ part.size
    steps = sum(part.steps for part in parts)
    # a product of k matrices of four rows in single precision is off by 4 k roundings at most [Higham 2002, 3.5]
    explained = np.abs(matrix - single) <= 4 * steps * ROUNDING * size + 1e-30
    return Place(matrix, size, steps) if explained.all() else _given(single)
