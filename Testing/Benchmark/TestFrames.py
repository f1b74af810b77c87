"""The same build renders the same frames, and what compares them sees a number that is another one.

usage: python3 TestFrames.py TREEAMR_FRAMES FOLDER
"""

import pathlib
import shutil
import struct
import subprocess
import sys

program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
frames, again = folder / "frames", folder / "frames-again"


def run(*arguments):
    return subprocess.run([program, *map(str, arguments)]).returncode


for out in (frames, again):
    shutil.rmtree(out, ignore_errors=True)
    assert run("write", out) == 0
assert len(list(frames.iterdir())) == 16
assert run("compare", frames, again) == 0

path = again / "procedural-volume.frame"
data = bytearray(path.read_bytes())
assert any(data)
value, = struct.unpack_from("<f", data, 4000)
struct.pack_into("<f", data, 4000, value + 2**-10)
path.write_bytes(data)
assert run("compare", frames, again) == 1
assert run("compare", frames, again, 2**-9) == 0
assert run("compare", frames, again, 2**-11) == 1
path.unlink()
assert run("compare", frames, again, 1) == 1
assert run("write") == 2
