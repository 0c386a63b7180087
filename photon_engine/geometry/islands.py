"""Connected parts of a mesh."""

from __future__ import annotations

import numpy as np

from ..jit import kernel


@kernel
def find_root(parents, x):
    """The representative of x's part, shortening the way there."""
    root = x
    while parents[root] != root:
        root = parents[root]
    while parents[x] != root:
        parent = parents[x]
        parents[x] = root
        x = parent
    return root


@kernel
def join_edges(edges, parents, ranks):
    """Join the parts of the two ends of each edge, by rank, in their order; then point every vertex at its root.

    edges : (E, 2) i32;  parents : (V,) i64, 0 .. V - 1 at the start;  ranks : (V,) i64, zeros
    """
    for e in range(len(edges)):
        a, b = find_root(parents, edges[e, 0]), find_root(parents, edges[e, 1])
        if a == b:
            continue
        if ranks[a] < ranks[b]:
            a, b = b, a
        parents[b] = a
        if ranks[a] == ranks[b]:
            ranks[a] += 1
    for v in range(len(parents)):
        find_root(parents, v)


def island_roots(n_vertices: int, edges: np.ndarray) -> np.ndarray:
    """The vertex that stands for each vertex's connected part, (V,) i64; the same as Cycles' for edges (E, 2) i32."""
    parents = np.arange(n_vertices, dtype=np.int64)
    join_edges(np.ascontiguousarray(edges, np.int32), parents, np.zeros(n_vertices, np.int64))
    return parents[parents]
