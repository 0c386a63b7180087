"""The benchmark's reference picture, by converged Cycles: ``python -m benchmarks.reference`` (about ten minutes)."""

from __future__ import annotations

from pathlib import Path

from tests.oracle import cycles, images

PATH = Path(__file__).resolve().parent / "cornell_caustics_soft_256.exr"
SIZE = 256


def main() -> None:
    """Render the Cornell box with its 0.5 m light at 256 x 256."""
    job = cycles.Job(
        builder="sample_blends.builders.cornell_caustics:build",
        arguments={"light_size": 0.5},
        width=SIZE,
        height=SIZE,
        spp=64,
        seconds=600,
        target=0.0015,
        max_batches=48,
    )
    images.write_reference(PATH, cycles.render(job))


if __name__ == "__main__":
    main()
