"""What a textured material costs a hit: ``python -m benchmarks.materials``, and part of `make bench`.

The material has 30 nodes, 24 of arithmetic and 6 images of 4 MB with bilinear interpolation, whose colour a Diffuse
BSDF takes; hits lie beside each other as in a tile of pixels, a texel apart, or anywhere, as photons land.
Thread CPU seconds of one core, the least of several repeats.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
HITS = 8192  # as many as an eye pass shades together
SIZE = 1024  # of the images
IMAGES = 6
REPEATS = 60
# bilinear lookups of the same texels through the C++ interface of OpenImageIO 3.2.2 (TextureSystem::texture, tiled .tx
# files in its cache, no mip map) on a machine of this kind: one by one, and in its batches of 16
OPENIMAGEIO_NS = {"side_by_side": [90.6, 68.1], "anywhere": [358.3, 296.1]}


class Maker:
    """A graph made node by node; each node has one output and gives the link to it."""

    def __init__(self) -> None:
        from photon_engine.scene.data import Node, Socket

        self.nodes: list[Node] = []
        self._node, self._socket = Node, Socket

    def add(self, kind: str, output: tuple[str, str], props: dict | None = None, **inputs):
        """Append a node; output: identifier and kind; inputs (underscores for spaces): (kind, value or link)."""
        sockets = {}
        for key, (socket, value) in inputs.items():
            name = key if key.endswith(("_001", "_002", "_Float", "_Color")) else key.replace("_", " ")
            linked = isinstance(value, str)
            place, _, source = value.partition(".") if linked else ("-1", "", "")
            sockets[name] = self._socket(None if linked else value, int(place), source, socket)
        self.nodes.append(self._node(kind, f"{kind} {len(self.nodes)}", props or {}, sockets, dict([output])))
        return f"{len(self.nodes) - 1}.{output[0]}"

    def math(self, operation: str, first, second=0.5):
        """A Math node."""
        inputs = {"Value": ("VALUE", first), "Value_001": ("VALUE", second), "Value_002": ("VALUE", 0.5)}
        return self.add("ShaderNodeMath", ("Value", "VALUE"), {"operation": operation}, **inputs)

    def mix(self, blend: str, factor, first, second):
        """A Mix node for colours."""
        return self.add("ShaderNodeMix", ("Result_Color", "RGBA"), {"data_type": "RGBA", "blend_type": blend},
                        Factor_Float=("VALUE", factor), A_Color=("RGBA", first), B_Color=("RGBA", second))


def graph_of_thirty():
    """The material's graph; UV Map and Diffuse BSDF are not counted among the 30."""
    from photon_engine.scene.data import Graph, Socket

    m = Maker()
    uv = m.add("ShaderNodeUVMap", ("UV", "VECTOR"), {"uv_map": "UVMap"})
    colors = []
    for k in range(IMAGES):
        place = m.add("ShaderNodeMapping", ("Vector", "VECTOR"), {"vector_type": "POINT"}, Vector=("VECTOR", uv),
                      Location=("VECTOR", (0.1 * k, 0.2, 0.0)), Rotation=("VECTOR", (0.0, 0.0, 0.3 * k)),
                      Scale=("VECTOR", (1.0, 1.0, 1.0)))
        colors.append(m.add("ShaderNodeTexImage", ("Color", "RGBA"), {"image": k, "interpolation": "Linear"},
                            Vector=("VECTOR", place)))
    low, high = m.math("MULTIPLY", _grey(m, colors[0]), 0.7), m.math("POWER", _grey(m, colors[1]), 1.5)
    mask = m.math("ABSOLUTE", m.math("SUBTRACT", low, high))
    factor = m.add("ShaderNodeMapRange", ("Result", "VALUE"), {"data_type": "FLOAT", "clamp": True},
                   Value=("VALUE", mask), From_Min=("VALUE", 0.1), From_Max=("VALUE", 0.6), To_Min=("VALUE", 0.0),
                   To_Max=("VALUE", 1.0))
    color = colors[0]
    for blend, other in zip(("MIX", "MULTIPLY", "OVERLAY", "SCREEN", "ADD"), colors[1:], strict=True):
        color = m.mix(blend, factor, color, other)
    color = m.add("ShaderNodeBrightContrast", ("Color", "RGBA"), {}, Color=("RGBA", color), Bright=("VALUE", 0.05),
                  Contrast=("VALUE", 0.1))
    color = m.add("ShaderNodeHueSaturation", ("Color", "RGBA"), {}, Color=("RGBA", color), Hue=("VALUE", 0.5),
                  Saturation=("VALUE", 0.8), Value=("VALUE", 1.0), Fac=("VALUE", 1.0))
    inverse = m.add("ShaderNodeInvert", ("Color", "RGBA"), {}, Color=("RGBA", color), Fac=("VALUE", factor))
    wave = m.math("SINE", m.math("MULTIPLY_ADD", high))
    color = m.mix("MIX", wave, inverse, color)
    m.add("ShaderNodeBsdfDiffuse", ("BSDF", "SHADER"), {}, Color=("RGBA", color), Roughness=("VALUE", 0.0))
    return Graph(m.nodes, Socket(None, len(m.nodes) - 1, "BSDF", "SHADER"))


def _grey(m: Maker, color: str) -> str:
    """A colour's luminance."""
    return m.add("ShaderNodeRGBToBW", ("Val", "VALUE"), {}, Color=("RGBA", color))


def best_ns(work) -> float:
    """Least thread CPU time of a call [ns a hit]."""
    work()
    best = float("inf")
    for _ in range(REPEATS):
        begin = time.thread_time()
        work()
        best = min(best, time.thread_time() - begin)
    return 1e9 * best / HITS


def places() -> dict[str, np.ndarray]:
    """UVs (n, 2) f32 of hits a texel apart, and anywhere."""
    y, x = np.divmod(np.arange(HITS), 128)
    tile = np.stack([x, y], axis=1).astype(np.float32) / SIZE + np.float32(0.1)
    return {"side_by_side": tile, "anywhere": np.random.default_rng(1).random((HITS, 2), np.float32)}


def measure() -> dict:
    """Microseconds a hit of the material with its rows of lobes, and nanoseconds an image lookup."""
    from photon_engine.bsdf.layout import pack
    from photon_engine.issues import IssueLog
    from photon_engine.scene.data import Image, Material
    from photon_engine.shading.material import compile_material
    from photon_engine.shading.points import probe_points
    from photon_engine.shading.textures import DECODE, LINEAR, REPEAT, sample_image

    rng = np.random.default_rng(0)
    pixels = [rng.integers(0, 256, (SIZE, SIZE, 4), np.uint8) for _ in range(IMAGES)]
    images = [Image(f"Image {k}", pixel, "sRGB", "STRAIGHT", True) for k, pixel in enumerate(pixels)]
    program = compile_material(Material("Thirty", graph_of_thirty()), images, IssueLog())
    points = probe_points(HITS, program.needs)
    result: dict = {"nodes": len(program.calls) - 2, "target_us_a_hit": 0.3, "openimageio_ns_a_lookup": OPENIMAGEIO_NS}
    for name, uv in places().items():
        points.uvs["UVMap"] = uv
        columns = np.ascontiguousarray(uv.T)
        result[name] = {
            "us_a_hit": 1e-3 * best_ns(lambda: pack(program.lobes(points), HITS, program.slots)),
            "ns_a_lookup": best_ns(lambda c=columns: [sample_image(p, c, LINEAR, REPEAT, DECODE) for p in pixels])
            / IMAGES,
        }  # fmt: skip
    result["texture_bytes"] = sum(pixel.nbytes for pixel in pixels)
    return result


if __name__ == "__main__":
    print(json.dumps(measure(), indent=1))
