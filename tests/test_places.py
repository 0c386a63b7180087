"""Places composed in double, where Blender's own are single: only where nothing else has moved an object."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from photon_engine.blender.places import Places
from tests.extract_help import cube, empty_scene, extract, link

FAR = 1e5
OFFSET = 0.0012345  # a hundredth of what single precision has 100 km away


@pytest.fixture(autouse=True)
def fresh_scene():
    return empty_scene()


def evaluated(ob):
    bpy.context.view_layer.update()
    return ob.evaluated_get(bpy.context.evaluated_depsgraph_get())


def family():
    """A far parent with a child a little beside it."""
    parent, child = link(bpy.data.objects.new("Parent", None)), cube("Child")
    child.parent = parent
    parent.location.x, child.location.x = FAR, OFFSET
    return parent, child


def x_of(ob):
    return Places().of(evaluated(ob))[0, 3]


def test_children_of_far_parents_keep_their_own_place():
    _, child = family()
    assert np.array(evaluated(child).matrix_world)[0, 3] == FAR  # what Blender itself makes of it
    assert x_of(child) - FAR == pytest.approx(OFFSET, abs=1e-9)
    grandchild = cube("Grandchild")
    grandchild.parent, grandchild.location.x = child, OFFSET
    assert x_of(grandchild) - FAR == pytest.approx(2 * OFFSET, abs=1e-9)


def test_scale_rotation_and_the_inverse_of_parenting_count():
    parent, child = family()
    parent.rotation_euler, parent.scale = (0.3, -0.4, 0.5), (2.0, 1.0, 0.5)
    child.matrix_parent_inverse = Matrix([[0, 1, 0, 3], [-1, 0, 0, 0.25], [0, 0, 1, 0], [0, 0, 0, 1]])
    ob = evaluated(child)
    single, double = np.array(ob.matrix_world), Places().of(ob)
    assert np.abs(double - single)[:3, 3].max() < 0.02
    assert double[:3, :3] == pytest.approx(single[:3, :3], abs=1e-6)
    parts = [np.array(m, float) for m in (parent.matrix_basis, child.matrix_parent_inverse, child.matrix_basis)]
    assert double == pytest.approx(parts[0] @ parts[1] @ parts[2], abs=1e-9)


@pytest.mark.parametrize("how", ["constraint", "vertex", "near", "path"])
def test_what_else_moves_an_object_is_left_to_blender(how):
    parent, child = family()
    if how == "constraint":
        child.constraints.new("COPY_LOCATION").target = parent
        child.constraints[0].use_offset = True
    elif how == "vertex":
        child.parent = cube("Big")
        child.parent.location.x, child.parent_type = FAR, "VERTEX"
    elif how == "near":
        parent.location.x = 500.0
    else:
        curve = bpy.data.curves.new("Path", "CURVE")
        curve.splines.new("POLY").points.add(1)
        curve.splines[0].points[1].co = (0.01, 0.0, 0.0, 1.0)
        child.parent = link(bpy.data.objects.new("Path", curve))
        child.parent.location.x, curve.use_path = FAR, True
    ob = evaluated(child)
    assert np.array_equal(Places().of(ob), np.array(ob.matrix_world, np.float64))


def test_instances_of_far_collections():
    """A collection's own instances in double; those of a collection within one as Blender has them."""
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    cube("Member", inner).location.x = OFFSET
    inner.instance_offset.x = -2 * OFFSET
    nested = bpy.data.objects.new("Nested", None)
    outer.objects.link(nested)
    cube("Direct", outer).location.x = OFFSET
    nested.instance_type, nested.instance_collection = "COLLECTION", inner
    instancer = link(bpy.data.objects.new("Instancer", None))
    instancer.instance_type, instancer.instance_collection, instancer.location.x = "COLLECTION", inner, FAR
    other = link(bpy.data.objects.new("Other", None))
    other.instance_type, other.instance_collection, other.location.x = "COLLECTION", outer, FAR
    found = {item.name: item.matrix[0, 3] - FAR for item in extract().instances}
    assert found["Instancer/Member"] == pytest.approx(3 * OFFSET, abs=1e-9)
    assert found["Other/Direct"] == pytest.approx(OFFSET, abs=1e-9)
    assert found["Other/Member"] == pytest.approx(3 * OFFSET, abs=2.0**-8)
