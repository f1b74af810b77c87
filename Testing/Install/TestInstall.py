"""Installs the build into a prefix and uses it from there: libraries, CMake package, Python package, plugin.

TestInstall.py [--python] [--pvpython <pvpython>] <cmake> <build folder> <scratch folder>
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

parser = argparse.ArgumentParser()
parser.add_argument("--python", action="store_true", help="there is a Python package")
parser.add_argument("--pvpython", help="there is a plugin; the interpreter that has our VTK")
parser.add_argument("cmake")
parser.add_argument("build", type=pathlib.Path)
parser.add_argument("scratch", type=pathlib.Path)
options = parser.parse_args()

here = pathlib.Path(__file__).parent
prefix = options.scratch / "prefix"

# Nothing of the build may be found but through the prefix.
environment = {k: v for k, v in os.environ.items()
               if k not in ("LD_LIBRARY_PATH", "PYTHONPATH", "PV_PLUGIN_PATH", "CMAKE_PREFIX_PATH")}


def run(*command, fails=False):
    print("+", *command, flush=True)
    done = subprocess.run([str(c) for c in command], env=environment, text=True, cwd=options.scratch,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    print(done.stdout, flush=True)
    if (done.returncode != 0) != fails:
        sys.exit(f"{command[0]} ended with {done.returncode}")
    return done.stdout


def run_with_environment_file(*command):
    return run("sh", "-c", '. "$0" && exec "$@"', prefix / "share/treeamr/env.sh", *command)


def check_libraries():
    """Each installed library finds the others in the prefix."""
    libraries = [f for f in prefix.rglob("*.so*") if not f.is_symlink()]
    if not libraries:
        sys.exit(f"{prefix}: no library was installed")
    for library in libraries:
        lines = run("ldd", library).splitlines()
        lost = [line for line in lines
                if "not found" in line or ("TreeAMR" in line and f"=> {prefix}/" not in line)]
        if lost:
            sys.exit(f"{library}: not found in the prefix: {lost}")


def check_headers():
    """What is installed is what the public headers include: no less, and nothing else."""
    folder = prefix / "include/treeamr"
    reached = set()
    core = {f.name for f in (here / "../../Core/include/treeamr").glob("*.h")}
    waiting = [f for f in folder.glob("*.h")
               if f.name in core or f.name.startswith("vtk") or f.name == "HyperTreeGridConverter.h"]
    if len(core) < 4 or not core <= {f.name for f in waiting}:
        sys.exit(f"{folder}: without some of {sorted(core)}")
    while waiting:
        header = waiting.pop()
        reached.add(header)
        for bracket, name in re.findall(
                r'^#include (["<])(?:treeamr/)?(\w+(?:/\w+)*\.(?:h|inl))[">]', header.read_text(), re.MULTILINE):
            included = folder / name
            if included.exists():
                if bracket != "<":
                    sys.exit(f"{header}: includes {name} as any program's")
                if included not in reached:
                    waiting.append(included)
            elif bracket != "<" and not name.startswith("vtk"):  # VTK's own
                sys.exit(f"{header}: includes {name}, which is not installed")
    others = {f for f in folder.rglob("*") if f.is_file()} - reached
    if others:
        sys.exit(f"installed, but included by no public header: {sorted(map(str, others))}")


shutil.rmtree(options.scratch, ignore_errors=True)
options.scratch.mkdir(parents=True)
run(options.cmake, "--install", options.build, "--prefix", prefix)
check_libraries()
check_headers()



def configure_consumer(name, where, *settings):
    folder = options.scratch / name
    return folder, [options.cmake, "-S", here / "Consumer", "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={where}",
                    "-DCMAKE_BUILD_TYPE=Release", *settings]


def build_and_run(folder, *targets):
    run(options.cmake, "--build", folder, "--target", *targets)
    programs = sorted(folder.glob("consume-*"))
    if not programs:
        sys.exit("no program was built")
    for program in programs:
        run(program)  # pictures beside it


consumer, configure = configure_consumer("consumer", prefix)
run(*configure)
build_and_run(consumer, "all")
# Who wants the core alone needs neither VTK nor ParaView, and may take it from the build.
for where in (prefix, options.build):
    consumer, configure = configure_consumer(
        "consumer-core", where, f"-DFROM_BUILD={int(where == options.build)}", "-DCOMPONENTS=Core", "-DCMAKE_DISABLE_FIND_PACKAGE_ParaView=ON",
        "-DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON", "--fresh")
    run(*configure)
    build_and_run(consumer, "consume-core")
_, configure = configure_consumer("consumer-none", prefix, "-DCOMPONENTS=Core;Extras")
message = run(*configure, fails=True)
if "TreeAMR has no component Extras" not in " ".join(message.split()):
    sys.exit("no reason for a component that there is not")
if pkg_config := shutil.which("pkg-config"):
    environment["PKG_CONFIG_PATH"] = str(next(prefix.rglob("pkgconfig")))
    flags = run(pkg_config, "--cflags", "--libs", "treeamr").split()
    program = options.scratch / "consume-by-pkg-config"
    run("c++", here / "Consumer/consumeCore.cpp", "-o", program, *flags,
        f"-Wl,-rpath,{next(prefix.rglob('libTreeAMRCore.so')).parent}")
    run(program)
run(options.cmake, "-S", here / "Parent", "-B", options.scratch / "parent", "-G", "Ninja",
    f"-DTREEAMR={(here / '../..').resolve()}")

python = [options.pvpython, "--force-offscreen-rendering"] if options.pvpython else [sys.executable]
if options.python:
    where = run_with_environment_file(*python, here / "importPackage.py")
    if str(prefix) not in where:
        sys.exit("treeamr was imported from elsewhere")
if options.pvpython:
    run_with_environment_file(*python, here / "loadPlugin.py")
