"""Checks the #include lines against the layering: Core <- Reader <- Rendering <- Plugin.

CheckIncludes.py <repository>   checks the repository: a message per violation, exit code 1 when there is one
CheckIncludes.py                checks itself: each kind of violation, written to a temporary folder, is found
"""

import pathlib
import re
import sys
import tempfile
import unittest

LAYERS = ["Core", "Reader", "Rendering", "Plugin"]
SUFFIXES = {".h", ".inl", ".cpp", ".cxx", ".txx"}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)

# What no file of a layer may include, by the name as it is spelled.
FORBIDDEN = {
    "Core": (r"vtk|pv|pq|mpi|Q[A-Z]", "Core knows no VTK, ParaView, Qt or MPI"),
    "Reader": (r"vtkPV|vtkSM|vtkSI|pv|pq|Q[A-Z]", "Reader knows no ParaView"),
    "Rendering": (r"vtkPV|vtkSM|vtkSI|pv|pq|Q[A-Z]", "Rendering knows no ParaView"),
}
# A part of Reader that needs no VTK: of its own folder and of Core only.
FOREST = "Reader/Forest"
P4EST = re.compile(r"(p4est|p6est|p8est|sc)(_[a-z0-9_]+)?\.h")
EMBREE = re.compile(r"embree\d*/")
EVERY_TARGET = "hwy/foreach_target.h"
INSTRUCTION_SETS = "InstructionSets.h"


def violations(root):
    """Messages about the sources below root, sorted."""
    root = pathlib.Path(root)
    files = {layer: sorted(f for f in (root / layer).rglob("*") if f.suffix in SUFFIXES) for layer in LAYERS}
    # Core's headers are included by their path below Core, those of the VTK folders by their name.
    layer_of = {}
    for layer in LAYERS:
        for file in files[layer]:
            layer_of[str(file.relative_to(root / layer))] = layer
            if layer != "Core":
                layer_of[file.name] = layer

    found = []
    embree_users = []
    for layer in LAYERS:
        for file in files[layer]:
            where = file.relative_to(root)
            includes = INCLUDE.findall(file.read_text(encoding="utf-8"))
            for name in includes:
                target = layer_of.get(name)
                if target and LAYERS.index(target) > LAYERS.index(layer):
                    found.append(f"{where}: includes {name} of {target}, which is above {layer}")
                elif not target and layer in FORBIDDEN and re.match(FORBIDDEN[layer][0], name):
                    found.append(f"{where}: includes {name}; {FORBIDDEN[layer][1]}")
                if where.is_relative_to(FOREST) and (name.startswith("vtk") or (
                        target == "Reader" and not name.startswith("Forest/"))):
                    found.append(f"{where}: includes {name}; {FOREST} knows no VTK")
                if name == EVERY_TARGET and INSTRUCTION_SETS not in includes[:includes.index(name)]:
                    found.append(f"{where}: includes {name} without {INSTRUCTION_SETS} before it, "
                                 "which says for what it is compiled")
                if P4EST.fullmatch(name):
                    found.append(f"{where}: includes {name}; libp4est (GPL) is for Testing/ only")
            if any(EMBREE.match(name) for name in includes):
                embree_users.append(str(where))
    if len(embree_users) > 1:
        found.append(f"{', '.join(embree_users)}: include Embree; one file may")
    if not any(files.values()):
        found.append(f"{root}: no sources in {', '.join(LAYERS)}")
    return sorted(found)


class SelfTest(unittest.TestCase):
    def check(self, sources):
        with tempfile.TemporaryDirectory() as folder:
            for name, includes in sources.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text("".join(f"#include {i}\n" for i in includes), encoding="utf-8")
            return violations(folder)

    def test_allowed(self):
        self.assertEqual([], self.check({
            "Core/Octree/Octree.h": ["<vector>"],
            "Core/Surface/Isosurface.cpp": ["<embree3/rtcore.h>", '"Octree/Octree.h"'],
            "Reader/Converter.h": ['"Octree/Octree.h"', '"vtkHyperTreeGrid.h"'],
            "Rendering/vtkMapper.cxx": ['"Converter.h"', '"vtkVolumeMapper.h"'],
            "Plugin/Representations/vtkRepresentation.cxx": ['"vtkPVRenderView.h"', '"Converter.h"'],
            "Testing/Reader/TestForest.cpp": ["<p8est.h>", '"Converter.h"'],
        }))

    def test_upwards(self):
        for low, high in [(a, b) for i, a in enumerate(LAYERS) for b in LAYERS[i + 1:]]:
            found = self.check({f"{low}/a/low.h": ['"high.h"'], f"{high}/b/high.h": []})
            self.assertEqual(1, len(found), (low, high))
            self.assertIn("above", found[0])

    def test_foreign(self):
        for layer, name in [("Core", "<vtkNew.h>"), ("Core", '"vtkNew.h"'), ("Core", "<mpi.h>"),
                            ("Core", "<QWidget>"), ("Reader", '"vtkPVView.h"'),
                            ("Rendering", '"vtkSMProxy.h"'), ("Rendering", '"pqView.h"')]:
            self.assertEqual(1, len(self.check({f"{layer}/a.h": [name]})), (layer, name))

    def test_forest(self):
        for name in ['"vtkNew.h"', '"Converter.h"']:
            self.assertEqual(1, len(self.check({"Reader/Forest/a.h": [name], "Reader/Converter.h": []})), name)
        self.assertEqual([], self.check(
            {"Reader/Forest/a.cpp": ['"Forest/a.h"', '"Error.h"', "<vector>"], "Reader/Forest/a.h": [],
             "Reader/b.cxx": ['"Forest/a.h"'], "Core/Error.h": []}))

    def test_p4est(self):
        for layer in LAYERS:
            for name in ["<p4est.h>", "<p8est_bits.h>", "<p4est_to_p8est.h>", "<sc.h>"]:
                self.assertEqual(1, len(self.check({f"{layer}/a.cpp": [name]})), (layer, name))

    def test_embree_twice(self):
        self.assertEqual(1, len(self.check({
            "Core/a.cpp": ["<embree3/rtcore.h>"], "Rendering/b.cxx": ["<embree3/rtcore.h>"]})))

    def test_instruction_sets(self):
        for includes, count in [(['"InstructionSets.h"', "<hwy/foreach_target.h>"], 0),
                                (["<hwy/foreach_target.h>", '"InstructionSets.h"'], 1),
                                (["<hwy/foreach_target.h>"], 1)]:
            self.assertEqual(count, len(self.check({"Core/a.cpp": includes})), includes)

    def test_spelling(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "Core").mkdir()
            pathlib.Path(folder, "Core/a.h").write_text("  #  include  <vtkNew.h>\n", encoding="utf-8")
            self.assertEqual(1, len(violations(folder)))

    def test_nothing_to_check(self):
        self.assertEqual(1, len(self.check({"README.md": []})))


if __name__ == "__main__":
    if len(sys.argv) == 1:
        unittest.main()
    messages = violations(sys.argv[1])
    for message in messages:
        print(message)
    sys.exit(1 if messages else 0)
