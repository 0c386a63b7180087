"""How kernels that call each other become machine code: each is typed once, and code is made for whole entries only.

Numba by itself makes, for every function and every combination of argument types, two wrappers for Python, and machine
code of the function with all that it calls; a lobe's sampler was optimised and assembled some 25 times on its way up
to the kernels that Python calls. Here a kernel is two dispatchers. A `Part` is what other kernels call: LLVM code as it
was lowered, without wrapper, optimisation or machine code. The entry is what Python calls: its parts are linked in and
made private, so that the optimiser may put a function where it is called once, drop arguments that nobody reads and
leave out what is not called; it sees each function once an entry.
"""

from __future__ import annotations

import functools
import importlib
import sys

from llvmlite.binding import parse_assembly
from numba.core import event as numba_event
from numba.core import sigutils, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.typing import make_concrete_template

from .kernel_cache import KernelCache


def plain_type(given):
    """The type as which a part takes an argument of this type: doubles, 64-bit integers, nothing known beforehand.

    So a part is compiled once, not once each for float32 and float64, for types of indices, for constants.
    """
    given = types.unliteral(given)
    if given == types.float32:
        return types.float64
    if isinstance(given, types.Integer) and given.signed:
        return types.int64
    if isinstance(given, types.UniTuple):
        return types.UniTuple(plain_type(given.dtype), given.count)
    if isinstance(given, types.Tuple):
        return types.Tuple([plain_type(item) for item in given.types])
    return given


class PartLibrary(JITCodeLibrary):
    """LLVM code to be linked into others; never machine code."""

    def _optimize_final_module(self):
        """Left to the entry's library."""

    def _finalize_final_module(self):
        """There is nothing to assemble."""
        self._finalized = True


class EntryLibrary(JITCodeLibrary):
    """Code that Python calls, with all parts that it needs."""

    def _optimize_final_module(self):
        """Make the parts private, then optimise everything together."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "linkonce_odr":
                function.linkage = "internal"
        super()._optimize_final_module()

    def _get_module_for_linking(self):
        """What the cache keeps beside machine code: the names that this defines, so that numba finds them.

        By default it is all the code that was optimised, for others to link, and its reading took a tenth of a warm
        start. But others link parts.
        """
        self._ensure_finalized()
        if self._shared_module is None:
            seen = [f for f in self._final_module.functions if not f.is_declaration and f.linkage.name != "internal"]
            self._shared_module = parse_assembly("\n".join(f'define void @"{f.name}"() {{ ret void }}' for f in seen))
        return self._shared_module


class _PartCompiler(Compiler):
    """Numba's compiler up to LLVM code."""

    def compile_extra(self, func):
        """As numba's."""
        self.state.flags.no_compile = True
        self.state.library = PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


class _EntryCompiler(Compiler):
    """Numba's compiler with a library of ours."""

    def compile_extra(self, func):
        """As numba's."""
        self.state.library = EntryLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


class Part(CPUDispatcher):
    """A kernel as other kernels call it. Not cached: whoever calls it from Python is, with everything that it needs."""

    def __init__(self, function, options):
        options = {**options, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        super().__init__(function, {}, options, _PartCompiler)

    def get_call_template(self, args, kws):
        """The one version to which these arguments, converted, go: (template, Python's signature, types, no kws)."""
        pysig, args = self._compiler.fold_argument_types(args, kws)
        args = tuple(plain_type(item) for item in args)
        self.compile(args)
        name = self.py_func.__name__
        template = make_concrete_template(f"CallTemplate({name})", name, [self.overloads[args].signature])
        return template, pysig, args, {}

    def compile(self, sig):
        """Lower for these types; out: the key under which numba's lowering finds the function."""
        args, return_type = sigutils.normalize_signature(sig)
        with global_compiler_lock, self._compiling_counter:
            if args not in self.overloads:
                details = {"dispatcher": self, "args": args, "return_type": return_type}
                with numba_event.trigger_event("numba:compile", data=details):
                    done = self._compiler.compile(args, return_type)
                done = done._replace(entry_point=(self, args))
                self.targetctx.insert_user_function(done.entry_point, done.fndesc, [done.library])
                self.overloads[args] = done
        return self.overloads[args].entry_point


@functools.cache
def load_numba_without_scipy() -> None:
    """Load what numba needs for calls, without scipy.linalg, which would take another tenth of a warm start.

    Numba looks for it to choose how np.inner is computed; np.dot and others look again when they are compiled.
    """
    blas = "scipy.linalg.cython_blas"
    hidden = blas not in sys.modules
    if hidden:
        sys.modules[blas] = None  # type: ignore[assignment]  # importing it fails
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        if hidden:
            del sys.modules[blas]


class Kernel:
    """A compiled function: called from Python it is an entry; to numba, which asks for its type, it shows its part.

    Both are made when they are asked for: of hundreds of kernels Python calls some thirty, and a filled cache asks
    for no part.
    """

    def __init__(self, function, options, cache_folder):
        """cache_folder(function): where to keep machine code."""
        functools.update_wrapper(self, function)
        self.py_func = function
        self._options = options
        self._cache_folder = cache_folder
        self._entry: CPUDispatcher | None = None
        self._part: Part | None = None

    @property
    def entry(self) -> CPUDispatcher:
        """What Python calls."""
        if self._entry is None:
            with global_compiler_lock:
                if self._entry is None:
                    load_numba_without_scipy()
                    entry = CPUDispatcher(self.py_func, {}, self._options, _EntryCompiler)
                    entry._cache = KernelCache(self.py_func, self._cache_folder(self.py_func))
                    self._entry = entry
        return self._entry

    @property
    def part(self) -> Part:
        """What other kernels call."""
        if self._part is None:
            with global_compiler_lock:
                if self._part is None:
                    self._part = Part(self.py_func, self._options)
        return self._part

    @property
    def _numba_type_(self) -> types.Dispatcher:
        """The type of the part."""
        return types.Dispatcher(self.part)

    def __call__(self, *args):
        """Compile for these types of arguments, unless that is done, and run."""
        return self.entry(*args)
