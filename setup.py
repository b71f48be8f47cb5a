"""The compiled core. Everything else about the package stands in pyproject.toml."""

import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup

# One wheel serves every CPython from 3.11 on, except free-threaded builds, which have no
# limited API: there the extension is built for the interpreter at hand.
LIMITED = not sysconfig.get_config_var("Py_GIL_DISABLED") and sys.implementation.name == "cpython"
MSVC = sys.platform == "win32" and "GCC" not in sys.version

# No contraction: a fused multiply-add on some machines only would give them other bits.
UNIX = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden"]
FLAGS = ["/std:c11", "/O2"] if MSVC else UNIX

core = Extension(
    "aoimpact._core",
    sources=sorted(path.as_posix() for path in Path("csrc").glob("*/*.c")),
    depends=["include/aoimpact.h", *sorted(path.as_posix() for path in Path("csrc").glob("*/*.h"))],
    include_dirs=["include", "csrc"],
    define_macros=[("Py_LIMITED_API", "0x030B0000")] if LIMITED else [],
    py_limited_api=LIMITED,
    extra_compile_args=FLAGS,
)

setup(
    ext_modules=[core],
    options={"bdist_wheel": {"py_limited_api": "cp311"}} if LIMITED else {},
)
