"""Counts the instructions of a small frame by valgrind's callgrind: to compare commits, as they hardly depend on what
else the machine does. Prints them and writes them to FILE.

usage: python3 instructions.py TREEAMR_FRAME FILE
"""

import json
import pathlib
import re
import subprocess
import sys


def count(program, what):
    output = subprocess.run(
        ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, what],
        capture_output=True, text=True, check=True).stderr
    return int(re.search(r"Collected : (\d+)", output)[1])


program, path = sys.argv[1:]
total = {what: count(program, what) for what in ("nothing", "volume", "isosurface")}
frames = {f"{what}, first frame": total[what] - total["nothing"] for what in ("volume", "isosurface")}
for what, instructions in frames.items():
    print(f"{what}: {instructions:,} instructions")
pathlib.Path(path).write_text(json.dumps(frames) + "\n")
