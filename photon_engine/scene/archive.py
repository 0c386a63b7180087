"""Reading an .npz archive that nobody vouches for: what it claims is checked before memory is spent on it."""

from __future__ import annotations

import math
import os
import zipfile
import zlib
from typing import NamedTuple

import numpy as np

KINDS = "biufc"  # of arrays: bool, integers, floats, complex; objects would need pickle
TEXT = "U"
PIECE = 1 << 24  # [bytes] read at once
MOST_UNPACKED = 1000  # times the file's size: the most that deflate can pack, less than members that share their bytes
BROKEN = (OSError, ValueError, EOFError, KeyError, NotImplementedError, RuntimeError, zipfile.BadZipFile,
          zipfile.LargeZipFile, zlib.error)  # what zipfile raises on files that are none, or not whole; fmt: skip


class BadArchive(Exception):
    """It is no archive of arrays, or does not hold what it says."""


class Header(NamedTuple):
    """What a member says of its array."""

    dtype: np.dtype
    shape: tuple[int, ...]
    fortran: bool
    start: int  # of the data in the member [bytes]

    @property
    def nbytes(self) -> int:
        """Size of the data."""
        return math.prod(self.shape) * self.dtype.itemsize


class Archive:
    """The arrays of an .npz file, by name. A BadArchive says what is wrong; FileNotFoundError when there is none."""

    def __init__(self, path: str | os.PathLike, text: bool = False) -> None:
        """Open it and read the headers; text: whether arrays of strings are allowed."""
        kinds = KINDS + TEXT * text
        size = os.stat(path).st_size
        try:
            self._zip = zipfile.ZipFile(path)
        except BROKEN as error:
            raise BadArchive("it is not an archive") from error
        try:
            members = {item.filename.removesuffix(".npy"): item for item in self._zip.infolist()}
            unpacked = sum(item.file_size for item in members.values())
            if unpacked > MOST_UNPACKED * size:
                raise BadArchive(f"{size} bytes claim to hold {unpacked}")
            if unpacked > (most := physical_memory()):
                raise BadArchive(f"it holds {unpacked / 2**30:.1f} GB, this machine has {most / 2**30:.1f}")
            self._members = members
            self.headers = {name: self._header(name, kinds) for name in members}
        except BaseException:
            self._zip.close()
            raise

    def __enter__(self) -> Archive:
        """For a with statement."""
        return self

    def __exit__(self, *_) -> None:
        """Close the file."""
        self._zip.close()

    def read(self, name: str) -> np.ndarray:
        """One array, writable."""
        if name not in self.headers:
            raise BadArchive(f"'{name}' is missing")
        header = self.headers[name]
        data = bytearray(header.nbytes)
        try:
            with self._zip.open(self._members[name]) as file:
                file.seek(header.start)
                view, filled = memoryview(data), 0
                while part := file.read(min(PIECE, len(data) - filled)):
                    view[filled : filled + len(part)] = part
                    filled += len(part)
                whole = filled == len(data) and not file.read(1)  # reading to the end checks the sum
        except BROKEN as error:
            raise BadArchive(f"'{name}' is not whole") from error
        if not whole:
            raise BadArchive(f"'{name}' is not whole")
        return np.frombuffer(data, header.dtype).reshape(header.shape, order="F" if header.fortran else "C")

    def _header(self, name: str, kinds: str) -> Header:
        """What a member says of itself, if the member is as long as that needs."""
        item = self._members[name]
        try:
            with self._zip.open(item) as file:
                version = np.lib.format.read_magic(file)
                read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
                shape, fortran, dtype = read[version](file)
                header = Header(dtype, shape, fortran, file.tell())
        except Exception as error:  # numpy's parser lets many kinds through
            raise BadArchive(f"'{name}' is no array") from error
        if dtype.kind not in kinds or dtype.hasobject or min(shape, default=0) < 0:
            raise BadArchive(f"'{name}' is an array of {dtype}")
        if header.start + header.nbytes != item.file_size:
            raise BadArchive(f"'{name}' is not as long as it says")
        return header


def physical_memory() -> int:
    """Memory of this machine [bytes]; where the system does not say (Windows), 64 GB."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return 64 * 2**30
