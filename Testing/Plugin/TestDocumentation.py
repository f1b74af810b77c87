"""The Python programs in the documentation run, and what its pages and the README link to is there.

usage: pvpython TestDocumentation.py PVPYTHON FOLDER
"""

import pathlib
import re
import subprocess
import sys
import unittest

import scene

folder = pathlib.Path(sys.argv.pop()).resolve()
pvpython = sys.argv.pop()
root = pathlib.Path(__file__).resolve().parents[2]
pages = [root / "README.md", *sorted((root / "Documentation").glob("*.md"))]


class TestDocumentation(unittest.TestCase):
    def test_links(self):
        links = [(page, link) for page in pages for link in re.findall(r"\]\(([^)#]+)", page.read_text())]
        self.assertGreater(len(links), 5)
        for page, link in links:
            if "://" not in link:
                self.assertTrue((page.parent / link).exists(), f"{page.name}: {link}")

    def test_files_in_pages_exist(self):
        for page in pages:
            for name in re.findall(r"`((?:Core|Reader|Rendering|Plugin|Testing|CMake|Documentation)/[\w./-]+)`", page.read_text()):
                if re.search(r"NAME|Name\b|\.\.\.", name):
                    continue  # stands for any
                there = list(root.glob(name)) or list(root.glob(name + ".*")) or list(root.glob(name + "*"))
                self.assertTrue(there, f"{page.name}: {name}")

    def test_targets_of_make(self):
        makefile = (root / "Makefile").read_text()
        for page in pages:
            for target in re.findall(r"(?:^    |`)make ([a-z-]+)", page.read_text(), re.MULTILINE):
                self.assertRegex(makefile, rf"(?m)^{target}:", page.name)

    def test_first_steps(self):
        text = (root / "Documentation/first-steps.md").read_text()
        programs = [re.sub("(?m)^    ", "", block) for block in re.findall(r"(?:^(?:    .*)?\n)+", text, re.MULTILINE)
                    if "import " in block]
        self.assertEqual(len(programs), 2)
        for program, picture in zip(programs, ("volume.png", "sphere.png")):
            (folder / "program.py").write_text(program)
            done = subprocess.run([pvpython, "--force-offscreen-rendering", "program.py"],
                                  cwd=folder, capture_output=True, text=True, timeout=300)
            self.assertEqual((done.returncode, done.stderr), (0, ""), program)
            self.assertGreater((folder / picture).stat().st_size, 2000)
        self.assertAlmostEqual(float(done.stdout), 0.4, 2)


if __name__ == "__main__":
    scene.main()
