"""The documentation beside what it is of: links, files, targets of make, Python programs, and every property of ParaView's panels
with its names, its default and what it may be.

usage: pvpython TestDocumentation.py PLUGIN-XML PVPYTHON FOLDER
"""

import ast
import pathlib
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import treeamr
from paraview import servermanager, simple

import scene

folder = pathlib.Path(sys.argv.pop()).resolve()
pvpython = sys.argv.pop()
plugin = ElementTree.parse(sys.argv.pop()).getroot()
root = pathlib.Path(__file__).resolve().parents[2]
pages = [root / "README.md", *sorted((root / "Documentation").rglob("*.md"))]
reference = root / "Documentation/reference"

# What sets a property from the data, whatever its default_values say.
DOMAINS_OF_DATA = ("BoundsDomain", "TreeAMRBoundsDomain", "TreeAMRRangeDomain", "ArrayListDomain",
                   "RepresentedArrayListDomain", "ProxyListDomain")


def anchors(page):
    """Those that a page's headings have on GitHub."""
    headings = re.findall(r"(?m)^#+ (.*)", page.read_text())
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def rows(page):
    """Of all tables of properties: name in Python, [in the panel, default, meaning]."""
    found = {}
    for line in (reference / page).read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 4 and (name := re.fullmatch(r"`(\w+)`", cells[1])):
            assert name[1] not in found, f"{page}: {name[1]} twice"
            found[name[1]] = [cells[0], *cells[2:]]
    return found


def in_python(proxy):
    """Names that the wrapper of a proxy offers, by those of the server manager."""
    iterator = proxy.SMProxy.NewPropertyIterator()
    keys = []
    while not iterator.IsAtEnd():
        keys.append(iterator.GetKey())
        iterator.Next()
    names = dict(zip(keys, proxy.ListProperties(), strict=True))
    if "Translation" in names:
        names["Translation"] = "Position"  # so called before 5.13, and in the pages
    return names


# What displays of later ParaViews than 5.11 have, and these choose.
LATER = ["Assembly"]


def is_hidden(element, smproperty):
    """Neither in the panel nor for scripts: what is internal, what lists of arrays are filled from, and what only states keep."""
    own = [decorator for decorator in element.iter("PropertyWidgetDecorator") if decorator.get("property") == element.get("name")]
    informs = smproperty.GetInformationOnly() and smproperty.GetPanelVisibility() == "never"
    return smproperty.GetIsInternal() or (informs and element.get("name").endswith("Info")) or bool(own)


def default(element):
    """As Python has it; None: it depends on the data, or there is none."""
    text = element.get("default_values")
    if text in (None, "none") or not element.tag.endswith("VectorProperty") or any(
            element.find(domain) is not None for domain in DOMAINS_OF_DATA):
        return None
    if element.tag.startswith("String"):
        return text
    for entry in element.iter("Entry"):
        if entry.get("value") == text:
            return entry.get("text")
    numbers = [float(number) for number in text.split()]
    return numbers if len(numbers) > 1 else numbers[0]


class TestDocumentation(unittest.TestCase):
    def test_links(self):
        links = [(page, *link) for page in pages for link in re.findall(r"\]\(([^)#]*)#?([^)]*)\)", page.read_text())]
        self.assertGreater(len(links), 50)
        for page, link, anchor in links:
            if "://" not in link:
                target = (page.parent / link).resolve() if link else page
                self.assertTrue(target.exists(), f"{page.name}: {link}")
                if anchor:
                    self.assertIn(anchor, anchors(target), f"{page.name}: {link}")

    def test_every_page_is_linked(self):
        linked = {(page.parent / link).resolve() for page in pages
                  for link in re.findall(r"\]\(([^)#]+)", page.read_text()) if "://" not in link}
        self.assertEqual(set(), set(pages) - linked - {root / "README.md"})

    def test_the_readme_is_short(self):
        self.assertLess(len((root / "README.md").read_text().splitlines()), 120)

    def test_files_in_pages_exist(self):
        for page in pages:
            for name in re.findall(r"`((?:Core|Reader|Rendering|Plugin|Testing|CMake|Documentation)/[\w./-]+)`", page.read_text()):
                if re.search(r"NAME|Name\b|\.\.\.", name):
                    continue  # stands for any
                there = list(root.glob(name)) or list(root.glob(name + ".*")) or list(root.glob(name + "*"))
                self.assertTrue(there, f"{page.name}: {name}")

    def test_tests_in_pages_exist(self):
        """Of `FileTest.name`, and of the beginnings of names before * or ..."""
        known = {f"{path.stem}.{name}" for path in (root / "Testing").rglob("*Test.cpp")
                 for name in re.findall(r"TEST(?:_F|_P)?\(\s*\w+,\s*(\w+)\)", path.read_text())}
        self.assertGreater(len(known), 400)
        found = set()
        for page in pages:
            for name in re.findall(r"`(\w+Test\.\w+)(?=[`.*])", page.read_text()):
                found.add(name)
                self.assertTrue(any(test.startswith(name) for test in known), f"{page.name}: {name}")
        self.assertGreater(len(found), 30)

    def test_programs_in_pages_exist(self):
        sources = "".join(path.read_text() for path in (root / "Testing").rglob("CMakeLists.txt"))
        built = set(re.findall(r"add_executable\(([\w-]+)", sources))
        for page in pages:
            for name in re.findall(r"build(?:-consumer|/bin)/([a-z-]+)", page.read_text()):
                self.assertIn(name, built, page.name)

    def test_names_in_pages_exist(self):
        """Classes of VTK and of ParaView's Python, functions for numpy."""
        classes = {path.stem for path in root.glob("[RP]*/**/vtkTreeAMR*.h")}
        for page in pages:
            text = page.read_text()
            for name in re.findall(r"\bvtkTreeAMR[A-Z]\w+", text):
                self.assertIn(name, classes | {"vtkTreeAMRReader", "vtkTreeAMRRendering"}, page.name)
            for name in re.findall(r"\bTreeAMR\w+(?=\()", text):
                self.assertTrue(hasattr(simple, name), f"{page.name}: {name}")
            for name in re.findall(r"\btreeamr\.((?!vtk|pc\b)\w+)", text):
                self.assertTrue(hasattr(treeamr, name), f"{page.name}: treeamr.{name}")

    def test_targets_of_make(self):
        makefile = (root / "Makefile").read_text()
        for page in pages:
            for target in re.findall(r"(?:^    |`)make ([a-z-]+)", page.read_text(), re.MULTILINE):
                self.assertRegex(makefile, rf"(?m)^{target}:", page.name)

    def check_properties(self, proxy, elements, *tables):
        """All properties of a proxy that XML elements describe have a row, and that is right."""
        names = in_python(proxy)
        found = {name: row for table in tables for name, row in rows(table).items()}
        seen = set()
        for element in elements:
            name = scene.of_display(element.get("name"))
            smproperty = proxy.SMProxy.GetProperty(name)
            if not smproperty:
                self.assertIn(name, LATER)
                seen.add(name)
                continue
            if is_hidden(element, smproperty):
                continue
            with self.subTest(page=tables[0], property=name):
                self.assertIn(names[name], found)
                seen.add(names[name])
                label, written, meaning = found[names[name]]
                if smproperty.GetPanelVisibility() != "never" and not label.startswith("(") and label != "Coloring":
                    self.assertEqual(smproperty.GetXMLLabel(), label)
                value = None if name in LATER else default(element)
                if value is None:
                    self.assertNotIn("`", written)
                else:
                    self.assertEqual(value, ast.literal_eval(written.strip("`")))
                text = "".join((reference / table).read_text() for table in tables)
                for entry in element.iter("Entry"):
                    self.assertIn(f'`"{entry.get("text")}"`', text)
                for domain in element:
                    low, high = domain.get("min"), domain.get("max")
                    if low and high and (low, high) != ("0", "1"):
                        self.assertIn(f"{low} to {high}", meaning)
        return seen

    def test_every_property_of_sources_and_filters(self):
        pages_of = set()
        for group in ("sources", "filters"):
            for element in plugin.findall(f"ProxyGroup[@name='{group}']/*"):
                page = element.get("label").removeprefix("Tree AMR ").lower().replace(" ", "-") + ".md"
                pages_of.add(page)
                own = [e for e in element if e.tag.endswith("Property")]
                for shared in element.iter("ExposedProperties"):
                    core = plugin.find("ProxyGroup/Proxy[@name='TreeAMRP4estReaderCore']")
                    exposed = {e.get("name") for e in shared}
                    own += [e for e in core if e.get("name") in exposed]
                smproxy = servermanager.ProxyManager().NewProxy("sources" if group == "sources" else "filters", element.get("name"))
                seen = self.check_properties(servermanager._getPyProxy(smproxy), own, page)
                self.assertEqual(set(rows(page)), seen, f"{page} has rows of what there is not")
        self.assertGreater(len(pages_of), 8)

    def test_every_property_of_the_representations(self):
        display = simple.Show(simple.TreeAMRExample(Dataset="Synthetic"), scene.view())
        shared = plugin.find("ProxyGroup/RepresentationProxy[@name='TreeAMRRepresentation']")
        every = set()
        for name, page in (("Volume", "volume.md"), ("Isosurface", "isosurface.md")):
            own = plugin.find(f"ProxyGroup/*[@name='TreeAMR{name}Representation']")
            elements = [e for parent in (shared, own) for e in parent if e.tag.endswith("Property")]
            seen = self.check_properties(display, elements, page, "displays.md")
            every |= seen
            self.assertLessEqual(set(rows(page)), seen, f"{page} has rows of what there is not")
        self.assertLessEqual(set(rows("displays.md")), every, "displays.md has rows of what there is not")

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
