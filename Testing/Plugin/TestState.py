"""Saved states bring back the representations, their properties and the picture."""

import os
import sys

from paraview import simple, smstate

import scene

MOTION = {"AutoAdjustSampleDistances": 0, "ImageSampleDistance": 1.5, "MinimumImageSampleDistance": 1.25,
          "MaximumImageSampleDistance": 8, "InteractiveRenderTime": 0.075, "LevelOfDetail": 2}

VISIBILITY = {"AmbientOcclusionSamples": 4, "AmbientOcclusionRadius": 0.25, "Shadows": 1}


class TestState(scene.TestCase):
    def make(self, kind):
        source = simple.TreeAMRExample(Dataset="Synthetic")
        view = scene.view()
        representation = simple.Show(source, view)
        simple.ColorBy(representation, ("CELLS", "xyz"))
        representation.SetRepresentationType(kind)
        representation.ScalarOpacityUnitDistance = 0.7
        representation.SamplesPerCell = 3
        for name, value in MOTION.items():
            setattr(representation, name, value)
        representation.Isovalues = [6.5, 20.0]
        for name, value in VISIBILITY.items():
            setattr(representation, name, value)
        scene.look(view)
        return scene.picture(view, "state-before")

    def check(self, kind, before):
        (source,) = simple.GetSources().values()
        view = simple.GetActiveView()
        representation = simple.GetRepresentation(source, view)
        self.assertEqual(kind, representation.Representation)
        self.assertEqual(0.7, representation.ScalarOpacityUnitDistance)
        self.assertEqual(3, representation.SamplesPerCell)
        for name, value in MOTION.items():
            self.assertEqual(value, getattr(representation, name), name)
        self.assertEqual([6.5, 20.0], list(representation.Isovalues))
        for name, value in VISIBILITY.items():
            self.assertEqual(value, getattr(representation, name), name)
        self.assertEqual(["CELLS", "xyz"], list(representation.IsosurfaceArray))
        view.UseFXAA = 0  # ParaView's states do not keep it
        after = scene.picture(view, "state-after")
        self.assertGreater(scene.drawn(after).mean(), 0.01)
        self.assertTrue(scene.close((before, after)))

    def test_round_trips(self):
        for kind in ("Tree AMR Volume", "Tree AMR Isosurface"):
            for suffix in ("pvsm", "py"):
                with self.subTest(kind=kind, suffix=suffix):
                    path = os.path.join(sys.argv[-1], "state." + suffix)
                    simple.ResetSession()
                    before = self.make(kind)
                    if suffix == "pvsm":
                        simple.SaveState(path)
                        simple.ResetSession()
                        simple.LoadState(path)
                    else:  # which SaveState() of ParaView 5.11 writes in the GUI only
                        state = smstate.get_state()
                        simple.ResetSession()
                        exec(compile(state, path, "exec"), {})
                    self.check(kind, before)


if __name__ == "__main__":
    scene.main()
