"""CheckTargets.py NINJA BUILD: the targets `product` and `demo` build all libraries, and no tests."""
import re
import subprocess
import sys

ninja, build = sys.argv[1:]
failures = []
for target, wanted, allowed in (
        ("product", {"TreeAMRCore", "TreeAMRReader", "TreeAMRRendering"}, set()),
        ("demo", {"TreeAMRCore", "TreeAMRReader", "TreeAMRRendering", "treeamr-demo-forest"},
         {"Demo/treeamr-demo-forest.cpp", "Support/ForestWriter.cpp", "Support/P4estSession.cpp"})):
    commands = subprocess.run([ninja, "-C", build, "-t", "commands", target], check=True, capture_output=True,
                              text=True).stdout
    linked = " ".join(path for path in re.findall(r" -o (\S+)", commands) if not path.endswith(".o"))
    failures += [f"{target} does not link {name}" for name in wanted if name not in linked]
    compiled = set(re.findall(r" -c \S*/Testing/(\S+)", commands))
    failures += [f"{target} compiles Testing/{source}" for source in compiled - allowed]
sys.exit("\n".join(failures) or 0)
