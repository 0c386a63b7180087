"""Open Image Denoise through its C interface, from the library that Blender itself carries.

Blender loads that library with its compositor and with Cycles, so inside Blender it is found by name; beside a bpy
wheel or an installed pyoidn wheel by its path. Nothing is bundled (50 MB a platform), and the pictures are denoised by
the very version that Cycles uses. Only the CPU is used: its result does not depend on the number of threads (tested).
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..issues import RenderError

NAMES = {"linux": "libOpenImageDenoise.so.2", "win32": "OpenImageDenoise.dll", "darwin": "libOpenImageDenoise.2.dylib"}
CPU = 1  # OIDNDeviceType
FLOAT3 = 3  # OIDNFormat
CANCELLED = 6  # OIDNError
# OIDNQuality: 0.42 and 0.18 s of one core for a picture of 256 x 256. Caustics had a fifth more error balanced
# (relMSE 0.0187 and 0.0225 on cornell_caustics), guides none
HIGH, BALANCED = 6, 5
MONITOR = ctypes.CFUNCTYPE(c_bool, c_void_p, c_double)

# name -> result, arguments (oidn.h of version 2)
SIGNATURES: dict[str, tuple[Any, list]] = {
    "oidnNewDevice": (c_void_p, [c_int]),
    "oidnSetDeviceInt": (None, [c_void_p, c_char_p, c_int]),
    "oidnSetDeviceBool": (None, [c_void_p, c_char_p, c_bool]),
    "oidnGetDeviceInt": (c_int, [c_void_p, c_char_p]),
    "oidnCommitDevice": (None, [c_void_p]),
    "oidnGetDeviceError": (c_int, [c_void_p, POINTER(c_char_p)]),
    "oidnReleaseDevice": (None, [c_void_p]),
    "oidnNewFilter": (c_void_p, [c_void_p, c_char_p]),
    "oidnSetSharedFilterImage": (
        None, [c_void_p, c_char_p, c_void_p, c_int, c_size_t, c_size_t, c_size_t, c_size_t, c_size_t]
    ),
    "oidnSetFilterBool": (None, [c_void_p, c_char_p, c_bool]),
    "oidnSetFilterInt": (None, [c_void_p, c_char_p, c_int]),
    "oidnSetFilterProgressMonitorFunction": (None, [c_void_p, MONITOR, c_void_p]),
    "oidnCommitFilter": (None, [c_void_p]),
    "oidnExecuteFilter": (None, [c_void_p]),
    "oidnReleaseFilter": (None, [c_void_p]),
}  # fmt: skip


class DenoiserMissing(RenderError):
    """No library of Open Image Denoise can be loaded."""


class Guides(NamedTuple):
    """Pictures of what is seen, without light: (h, w, 3) f32."""

    albedo: np.ndarray
    normal: np.ndarray


def candidates() -> list[str]:
    """Names and paths under which the library may be found, the likeliest first."""
    name = NAMES.get(sys.platform, "")
    if not name:
        return []
    found = [name]
    for package, folders in (("bpy", ("lib", ".")), ("pyoidn", ("oidn/lib", "oidn/bin"))):
        spec = find_spec(package)
        for root in (spec.submodule_search_locations or []) if spec else []:
            # the bpy package lies in .../bpy; a loaded one names its own scripts/modules/bpy, four folders below it
            bases = [Path(root), *Path(root).parents[:4]] if package == "bpy" else [Path(root)]
            found += [str(base / folder / name) for base in bases for folder in folders]
    return [item for item in found if item == name or Path(item).is_file()]


@cache
def library() -> ctypes.CDLL:
    """The library, loaded and declared; a DenoiserMissing says where it was looked for."""
    tried = candidates()
    for path in tried:
        try:
            lib = ctypes.CDLL(path)
            for name, (result, arguments) in SIGNATURES.items():
                function = getattr(lib, name)
                function.restype, function.argtypes = result, arguments
        except (OSError, AttributeError):
            continue
        return lib
    raise DenoiserMissing(
        "Denoise", "Open Image Denoise cannot be loaded, the picture stays as it is",
        "use a Blender that has it, or install the pyoidn package",
    )  # fmt: skip


class Oidn:
    """A device; one filter runs at a time. Close it, or use it with `with`."""

    def __init__(self, threads: int = 0) -> None:
        self._lib = library()
        self._device = self._lib.oidnNewDevice(CPU)
        if threads:
            self._lib.oidnSetDeviceInt(self._device, b"numThreads", threads)
        # by default it pins its threads, and with them ours, to cores
        self._lib.oidnSetDeviceBool(self._device, b"setAffinity", False)
        self._lib.oidnCommitDevice(self._device)
        self._check()

    @property
    def version(self) -> str:
        """Version of the library, as 2.5.0."""
        number = self._lib.oidnGetDeviceInt(self._device, b"version")
        return f"{number // 10000}.{number // 100 % 100}.{number % 100}"

    def color(
        self, picture: np.ndarray, guides: Guides, cancelled: Callable[[], bool], quality: int = HIGH
    ) -> np.ndarray | None:
        """A picture of radiance (h, w, 3) f32 without its noise; the guides must be clean. None when cancelled."""
        images = {"color": picture, "albedo": guides.albedo, "normal": guides.normal}
        return self._filter(images, {"hdr": True, "cleanAux": True}, quality, cancelled)

    def guide(self, name: str, picture: np.ndarray, cancelled: Callable[[], bool]) -> np.ndarray | None:
        """A guide (h, w, 3) f32, "albedo" or "normal", without its noise. None when cancelled."""
        return self._filter({name: picture}, {}, BALANCED, cancelled)

    def _filter(
        self, images: dict[str, np.ndarray], flags: dict[str, bool], quality: int, cancelled: Callable[[], bool]
    ) -> np.ndarray | None:
        """Run the ray-tracing filter."""
        lib = self._lib
        kept = {name: np.ascontiguousarray(image, np.float32) for name, image in images.items()}
        kept["output"] = out = np.empty_like(next(iter(kept.values())))
        height, width, _ = out.shape
        monitor = MONITOR(lambda _user, _fraction: not cancelled())
        handle = lib.oidnNewFilter(self._device, b"RT")
        try:
            for name, image in kept.items():
                lib.oidnSetSharedFilterImage(handle, name.encode(), image.ctypes.data, FLOAT3, width, height, 0, 0, 0)
            for name, value in flags.items():
                lib.oidnSetFilterBool(handle, name.encode(), value)
            lib.oidnSetFilterInt(handle, b"quality", quality)
            lib.oidnSetFilterProgressMonitorFunction(handle, monitor, None)
            lib.oidnCommitFilter(handle)
            lib.oidnExecuteFilter(handle)
        finally:
            lib.oidnReleaseFilter(handle)
        return None if self._check() else out

    def _check(self) -> bool:
        """Raise what the device complains of; whether it was cancelled."""
        text = c_char_p()
        code = self._lib.oidnGetDeviceError(self._device, byref(text))
        if code in (0, CANCELLED):
            return code == CANCELLED
        reason = (text.value or b"").decode(errors="replace")
        raise RenderError("Denoise", f"Open Image Denoise failed: {reason}", "a smaller picture, or denoise off")

    def close(self) -> None:
        """Let the device go."""
        if self._device:
            self._lib.oidnReleaseDevice(self._device)
            self._device = None

    def __enter__(self) -> Oidn:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
