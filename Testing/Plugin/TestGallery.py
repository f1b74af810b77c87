"""Makes the pictures of Documentation/gallery.md by the scripts that it names, and index.html of them: each script runs without a
message and writes its picture, every example of a picture is in the page, and the picture in the README is what its script draws.

usage: python3 TestGallery.py PVPYTHON FOLDER
"""

import html
import pathlib
import re
import subprocess
import sys

import numpy
from matplotlib import image

root = pathlib.Path(__file__).resolve().parents[2]
page = (root / "Documentation/gallery.md").read_text()
pvpython, folder = sys.argv[1], pathlib.Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
failures = []


def run(script):
    done = subprocess.run([pvpython, "--force-offscreen-rendering", str(script), str(folder)], capture_output=True, text=True,
                          timeout=300)
    if done.returncode or done.stderr:
        failures.append(f"{script.name} ended with {done.returncode}:\n{done.stderr}")


def load(path):
    """Red, green and blue, 0 to 1."""
    return image.imread(path)[..., :3]


rows = re.findall(r"(?m)^\| `([\w-]+\.png)` \| `([\w./-]+\.py)` \| (.*) \|$", page)
examples = {path.relative_to(root).as_posix() for path in (root / "Testing/Plugin/Examples").glob("*.py")
            if f"{path.stem}.png" in path.read_text()}
if missing := examples - {script for _, script, _ in rows}:
    failures.append(f"gallery.md does not have {', '.join(sorted(missing))}")
for script in sorted({script for _, script, _ in rows}):
    run(root / script)
figures = []
for picture, script, text in rows:
    path = folder / picture
    if not path.exists():
        failures.append(f"{script} wrote no {picture}")
    elif len(numpy.unique(numpy.round(255 * load(path)).reshape(-1, 3), axis=0)) < 100:
        failures.append(f"{picture} has less than 100 colours")
    caption = html.escape(text.replace('*', ''))
    figures.append(
        f'<figure><img src="{picture}" alt=""><figcaption>{caption} <code>{script}</code></figcaption></figure>')
(folder / "index.html").write_text(
    "<!DOCTYPE html><meta charset=utf-8><title>TreeAMR: gallery</title>"
    "<style>body { font-family: sans-serif; max-width: 60em; margin: auto } img { max-width: 100% }</style>\n" + "\n".join(figures))

# Edges of polygons, and lines, are a little different from one OpenGL to the next.
committed, drawn = load(root / "Documentation/everything.png"), load(folder / "everything.png")
if committed.shape != drawn.shape or numpy.sqrt(((committed - drawn) ** 2).mean()) > 0.02:
    failures.append("Documentation/everything.png is not what everything.py draws")
print(folder / "index.html")
sys.exit("\n".join(failures) or 0)
