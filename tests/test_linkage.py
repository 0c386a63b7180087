"""Kernels that kernels call are typed once, converted to, and never assembled by themselves."""

import numpy as np
from numba import types

from photon_engine.jit import compiled_functions, kernel
from photon_engine.linkage import PartLibrary, plain_type

V3 = types.UniTuple(types.float64, 3)


@kernel
def blend(a, s, k):
    return (a[0] * s, a[1] * s, a[2] * s + k)


@kernel
def calls_in_many_ways(rows, i):
    x = blend((rows[i, 0], rows[i, 1], rows[i, 2]), rows[i, 0], 0)
    y = blend((1.0, 2.0, 3.0), 0.5, i)
    z = blend((1.0, 2.0, 3.0), np.float32(2.0), np.int32(7))
    return x[2] + 10.0 * y[2] + 100.0 * z[2]


def test_plain_types():
    assert plain_type(types.float32) == types.float64
    assert plain_type(types.int32) == plain_type(types.literal(3)) == types.int64
    assert plain_type(types.uint32) == types.uint32 and plain_type(types.uint64) == types.uint64
    assert plain_type(types.literal(True)) == types.boolean
    assert plain_type(types.UniTuple(types.float32, 3)) == V3
    nested = types.Tuple([types.UniTuple(types.float32, 3), types.literal(1), types.float32[:]])
    assert plain_type(nested) == types.Tuple([V3, types.int64, types.float32[:]])


def test_one_version_serves_all_callers_and_has_no_machine_code():
    before = compiled_functions()
    rows = np.float32([[0.0] * 3, [2.0, 3.0, 4.0]])
    calls_in_many_ways.part.compile((types.float32[:, ::1], types.int64))
    assert calls_in_many_ways(rows, 1) == 8.0 + 10.0 * 2.5 + 100.0 * 13.0
    assert compiled_functions() - before >= 2
    assert len(blend.part.overloads) == 1
    (done,) = blend.part.overloads.values()
    assert isinstance(done.library, PartLibrary) and done.signature.args == (V3, types.float64, types.int64)
    assert not done.library.codegen._engine.is_symbol_defined(done.fndesc.mangled_name)
