"""What a simulation shows of itself by Catalyst, treeamr-in-situ: pictures of each step, on two and four ranks those of one.

TestInSitu.py <folder>                    compares its folders 1, 2 and 4, of a run on so many ranks each
"""

import os
import re
import sys

import scene

folder = sys.argv[1]
names = sorted(os.listdir(os.path.join(folder, "1")))
steps = sorted({re.fullmatch(r"(volume|isosurface)_(\d{4})\.png", name)[2] for name in names})
assert steps == [f"{step:04}" for step in range(4)], steps
assert len(names) == 2 * len(steps), names

for kind in ("volume", "isosurface"):
    before = None
    for step in steps:
        one, two, four = (
            scene.load(os.path.join(folder, ranks, f"{kind}_{step}.png")) for ranks in ("1", "2", "4"))
        assert scene.drawn(one).mean() > 0.05
        assert before is None or (one != before).any(), "the dye has moved"
        before = one
        for ranks, other in ((2, two), (4, four)):
            difference = abs(one - other)
            far = (difference.max(axis=2) > 2).mean()
            print(kind, step, ranks, "ranks: largest difference", difference.max(), "mean", difference.mean(), "far", far)
            # Colours and opacities of each rank are rounded to 8 bits before they are composited: seen are 4, and 3 or 4 in
            # 77 of 160,000 pixels; no seam.
            assert difference.max() <= (4 if kind == "volume" else 1)
            assert far < 0.001
