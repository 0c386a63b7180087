"""Loops of the scalar functions over batches, for tests, tools and measurements."""

from __future__ import annotations

import numpy as np

from ..jit import kernel
from ..vec import load3, store3
from .layout import LobeRows
from .surface import emission, eval_rough, prepare, sample


@kernel
def sample_loop(rows, index, ns, ng, wo, cls, adjoint, threshold, u, scratch, ok, wi, weight, pdf, eta):
    """`prepare` and `sample` for each hit i with row index[i]."""
    for i in range(index.shape[0]):
        n = load3(ns, i)
        g = load3(ng, i)
        w = load3(wo, i)
        prepare(rows, index[i], n, g, w, threshold, scratch)
        good, d, value, density, crossed = sample(
            rows, index[i], n, g, w, cls, scratch, (u[i, 0], u[i, 1], u[i, 2]), adjoint, threshold
        )
        ok[i] = good
        store3(wi, i, d)
        store3(weight, i, value)
        pdf[i] = density
        eta[i] = crossed


@kernel
def eval_loop(rows, index, ns, ng, wo, wi, threshold, scratch, f, pdf):
    """`prepare` and `eval_rough` for each hit i with row index[i]."""
    for i in range(index.shape[0]):
        n = load3(ns, i)
        g = load3(ng, i)
        w = load3(wo, i)
        prepare(rows, index[i], n, g, w, threshold, scratch)
        value, density = eval_rough(rows, index[i], n, g, w, load3(wi, i), scratch)
        store3(f, i, value)
        pdf[i] = density


@kernel
def prepare_loop(rows, index, ns, ng, wo, threshold, scratch, p, le):
    """`prepare` and `emission` for each hit i with row index[i]."""
    for i in range(index.shape[0]):
        a, b, c = prepare(rows, index[i], load3(ns, i), load3(ng, i), load3(wo, i), threshold, scratch)
        p[i, 0] = a
        p[i, 1] = b
        p[i, 2] = c
        store3(le, i, emission(rows, index[i], scratch))


def _scratch(rows: LobeRows) -> np.ndarray:
    """A work array for the rows."""
    return np.zeros((rows.kind.shape[1], 8))


def sample_batch(rows: LobeRows, index, frames, u, *, cls=-1, adjoint=0, threshold=0.05):
    """(ok, wi, weight, pdf_w, eta) for hits with `frames` = (ns, ng, wo), each (n, 3) f64, and numbers u (n, 3)."""
    ns, ng, wo = frames
    n = len(index)
    out = (np.zeros(n, np.bool_), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n))
    sample_loop(rows, index, ns, ng, wo, cls, adjoint, threshold, u, _scratch(rows), *out)
    return out


def eval_batch(rows: LobeRows, index, frames, wi, *, threshold=0.05):
    """(f rgb, pdf_w) of the rough lobes for hits with `frames` = (ns, ng, wo) and directions wi (n, 3) f64."""
    ns, ng, wo = frames
    f, pdf = np.zeros((len(index), 3)), np.zeros(len(index))
    eval_loop(rows, index, ns, ng, wo, wi, threshold, _scratch(rows), f, pdf)
    return f, pdf


def prepare_batch(rows: LobeRows, index, frames, *, threshold=0.05):
    """(sampling weights (n, 3) by class null, sharp, rough; emitted radiance (n, 3)) for hits."""
    ns, ng, wo = frames
    p, le = np.zeros((len(index), 3)), np.zeros((len(index), 3))
    prepare_loop(rows, index, ns, ng, wo, threshold, _scratch(rows), p, le)
    return p, le
