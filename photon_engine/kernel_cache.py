"""Where the machine code of a kernel is kept between runs: one file for each version, named after what it is.

Numba keeps an index beside numbered files. Two processes that compile at once both read the index before either has
written, both take number 1 for different types of arguments, and the index of one ends beside the code of the other:
the next run calls code made for other arguments, and crashes. Here the name of a file is a hash of the function, its
types and the processor, so that whoever writes it writes the same; it appears whole or not at all, and says what it
holds and how its bytes add up. What cannot be read is compiled anew, what cannot be written is not kept.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import uuid
from pathlib import Path

from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

DIGEST = hashlib.sha256().digest_size


class KernelCache:
    """The compiled versions of one function, as `Dispatcher._cache` uses them.

    folder : of this function's module; made when there is something to write
    failed : the first error on writing, of any function; None: all was kept
    told : whether the user knows
    """

    failed: OSError | None = None
    told = False

    def __init__(self, function, folder: Path) -> None:
        self.function = function
        self.folder = folder

    @property
    def cache_path(self) -> str:
        """For `Dispatcher.stats`."""
        return str(self.folder)

    def enable(self) -> None:
        """Asked for by numba; it always is."""

    def flush(self) -> None:
        """Forget this function's versions (`Dispatcher.recompile`)."""
        for path in self.folder.glob(f"{self.function.__qualname__}-*.nbc"):
            path.unlink(missing_ok=True)

    def key(self, signature, codegen) -> bytes:
        """What a version is: function, types of arguments, processor, bytecode.

        The module's name too, since types are stored by the name under which they can be imported.
        """
        code = self.function.__code__
        parts = (self.function.__module__, code.co_name, code.co_firstlineno, signature, codegen.magic_tuple())
        return repr(parts).encode() + code.co_code

    def path(self, key: bytes) -> Path:
        """The file of a version."""
        return self.folder / f"{self.function.__qualname__}-{hashlib.sha256(key).hexdigest()[:24]}.nbc"

    def load_overload(self, signature, target_context):
        """The compiled version for these types of arguments, or None."""
        target_context.refresh()
        key = self.key(signature, target_context.codegen())
        reduced = read(self.path(key), key)
        return None if reduced is None else CompileResult._rebuild(target_context, *reduced)

    def save_overload(self, signature, compiled) -> None:
        """Keep a compiled version; a folder that cannot be written, or a full disk, is noted in `failed`."""
        if compiled.lifted or compiled.library.has_dynamic_globals:
            return  # holds addresses of this process
        key = self.key(signature, compiled.codegen)
        try:
            write(self.path(key), key, compiled._reduce())
        except OSError as error:
            KernelCache.failed = KernelCache.failed or error


def write(path: Path, key: bytes, content) -> None:
    """A file that holds key and content, there at once as a whole."""
    body = dumps((key, content))
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f"{path.name}.{uuid.uuid4().hex[:12]}.tmp")
    try:
        beside.write_bytes(hashlib.sha256(body).digest() + body)
        os.replace(beside, path)
    finally:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)


def read(path: Path, key: bytes):
    """The content of a file with this key; None where there is none, or another, or a damaged one."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    if hashlib.sha256(data[DIGEST:]).digest() != data[:DIGEST]:
        return None
    said, content = pickle.loads(data[DIGEST:])
    return content if said == key else None
