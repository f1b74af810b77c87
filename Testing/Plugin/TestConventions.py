"""ParaView's conventions that both representations follow: transforms, separate colour maps, states of every property,
progress, and which of Surface's properties their panels show."""

import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy
from paraview import servermanager, simple, smstate
from vtkmodules.vtkRenderingCore import vtkActor

import scene

KINDS = ("Tree AMR Volume", "Tree AMR Isosurface")
PLUGIN_XML = sys.argv[1]

# What the panels show of Surface's. Those of blocks and MultiComponentsMapping ParaView hides itself, of other inputs and types
# than its Volume; the two colours belong to the choice of arrays.
SHOWN = {
    "Input", "Representation", "ColorArrayName", "LookupTable", "AmbientColor", "DiffuseColor",
    "MultiComponentsMapping",
    scene.TRANSLATION, "Scale", "Orientation", "Origin", "Pickable",
    "Ambient", "Diffuse", "Specular", "SpecularPower", "MapScalars"}
SHOWN_OF_ISOSURFACES = {"SpecularColor", "Opacity", "Interpolation"}


def changed(prop):
    """Another value that the property may have; None: there is none that is simple."""
    smproperty = prop.SMProperty
    if not smproperty.IsA("vtkSMVectorProperty") or smproperty.GetInformationOnly() or smproperty.GetIsInternal():
        return None
    value = prop.GetData()
    if smproperty.IsA("vtkSMIntVectorProperty"):
        domain = smproperty.FindDomain("vtkSMEnumerationDomain") or smproperty.FindDomain("vtkSMBooleanDomain")
        if domain and domain.IsA("vtkSMEnumerationDomain"):
            texts = [domain.GetEntryText(i) for i in range(domain.GetNumberOfEntries())]
            return texts[(texts.index(value) + 1) % len(texts)] if value in texts and len(texts) > 1 else None
        if domain:
            return 1 - value
        return value + 1 if isinstance(value, int) else None
    if smproperty.IsA("vtkSMDoubleVectorProperty"):
        if isinstance(value, (int, float)):
            return 1.25 * value + 0.375 if value != 1 else 1.5
        return [1.25 * v + 0.375 for v in value] if len(value) > 0 else None
    return None


class TestConventions(scene.TestCase):
    def show(self, kind):
        self.source = simple.TreeAMRExample(Dataset="Synthetic")
        self.view = scene.view()
        self.representation = simple.Show(self.source, self.view)
        simple.ColorBy(self.representation, ("CELLS", "xyz"))
        self.representation.SetRepresentationType(kind)
        scene.look(self.view)

    def picture(self, name):
        return scene.picture(self.view, "conventions-" + name)

    def test_user_transform(self):
        """A matrix places the data as Position, Orientation and Scale do; so are their bounds."""
        for kind in KINDS:
            with self.subTest(kind=kind):
                simple.ResetSession()
                self.show(kind)
                plain = self.picture("plain")
                setattr(self.representation, scene.TRANSLATION, [1, 0.5, 0])
                self.representation.Scale = [0.5, 0.5, 0.5]
                moved = self.picture("moved")
                simple.ResetCamera(self.view)
                centre = list(self.view.CameraFocalPoint)
                scene.look(self.view)
                close_up = self.picture("close-up")
                setattr(self.representation, scene.TRANSLATION, [0, 0, 0])
                self.representation.Scale = [1, 1, 1]
                scene.look(self.view)
                self.assertTrue(scene.close((plain, self.picture("back"))))
                self.representation.UserTransform = [0.5, 0, 0, 1, 0, 0.5, 0, 0.5, 0, 0, 0.5, 0, 0, 0, 0, 1]
                self.assertTrue(scene.close((moved, self.picture("user"))))
                self.assertFalse(scene.close((plain, moved)))
                simple.ResetCamera(self.view)
                self.assertLess(numpy.abs(numpy.subtract(self.view.CameraFocalPoint, centre)).max(), 1e-6)
                scene.look(self.view)
                self.assertTrue(scene.close((close_up, self.picture("user-close-up"))))

    def test_bounds_of_turned_displays(self):
        """The view knows where a display is that is turned or mirrored: it finds it, and cuts nothing away."""
        corners = numpy.array([(x, y, z) for x in (0, 4) for y in (0, 4) for z in (0, 4)], float)
        for kind in KINDS:
            simple.ResetSession()
            self.show(kind)
            for orientation, scale, origin in (
                    ((0, 0, 180), (1, 1, 1), (0, 0, 0)), ((0, 0, 180), (1, 1, 1), (30, 30, 0)),
                    ((0, 0, 45), (1, 1, 1), (0, 0, 0)), ((30, 40, 50), (1, 2, 3), (1, 0, 0)),
                    ((0, 0, 0), (-1, 1, -2), (0, 0, 0))):
                with self.subTest(kind=kind, orientation=orientation, scale=scale, origin=origin):
                    self.representation.Orientation = orientation
                    self.representation.Scale = scale
                    self.representation.Origin = origin
                    prop = vtkActor()
                    prop.SetOrientation(orientation)
                    prop.SetScale(scale)
                    prop.SetOrigin(origin)
                    matrix = numpy.array([[prop.GetMatrix().GetElement(r, c) for c in range(4)] for r in range(4)])
                    places = corners @ matrix[:3, :3].T + matrix[:3, 3]
                    simple.Render(self.view)
                    simple.ResetCamera(self.view)
                    self.assertGreater(scene.drawn(self.picture("turned")).mean(), 0.005)
                    centre = (places.min(axis=0) + places.max(axis=0)) / 2
                    self.assertLess(numpy.abs(self.view.CameraFocalPoint - centre).max(), 1e-5)
                    camera = self.view.GetActiveCamera()
                    away = (places - camera.GetPosition()) @ camera.GetDirectionOfProjection()
                    near, far = camera.GetClippingRange()
                    self.assertLess(near, max(away.min(), 0.02 * far))
                    self.assertGreater(far, away.max())

    def test_separate_colour_maps(self):
        """Two displays of one array in their own colours."""
        for kind in KINDS:
            with self.subTest(kind=kind):
                simple.ResetSession()
                self.show(kind)
                shared = self.picture("shared")
                self.representation.UseSeparateColorMap = 1
                simple.ColorBy(self.representation, ("CELLS", "xyz"), True)
                own = self.representation.LookupTable
                self.assertNotEqual(own, simple.GetColorTransferFunction("xyz"))
                scene.set_colour(own, 0, 64, (0, 1, 0))
                green = self.picture("separate")
                self.assertFalse(scene.close((shared, green)))
                if kind == "Tree AMR Volume":
                    seen = scene.drawn(green)
                    self.assertEqual(0, green[seen][:, (0, 2)].max())
                self.representation.UseSeparateColorMap = 0
                simple.ColorBy(self.representation, ("CELLS", "xyz"))
                self.assertTrue(scene.close((shared, self.picture("shared-again"))))

    def test_states_keep_every_property(self):
        """Each of both representations' properties is changed, saved and loaded, as .pvsm and as Python."""
        names = self.own_properties()
        self.assertGreater(len(names), 40)
        for kind in KINDS:
            for suffix in ("pvsm", "py"):
                with self.subTest(kind=kind, suffix=suffix):
                    simple.ResetSession()
                    self.show(kind)
                    given = {}
                    kept = names - {"UserTransform"} if suffix == "py" else names  # ParaView's Python leaves it out
                    for name in sorted(kept):
                        prop = self.representation.GetProperty(name)
                        value = changed(prop) if prop is not None else None
                        if value is not None:
                            setattr(self.representation, name, value)
                            given[name] = prop.GetData()
                    for name, prop in ((n, self.representation.GetProperty(n)) for n in given):
                        given[name] = list(prop.GetData()) if hasattr(prop.GetData(), "__len__") and \
                            not isinstance(prop.GetData(), str) else prop.GetData()  # some change others
                    self.assertGreater(len(given), 30)
                    path = os.path.join(sys.argv[-1], "conventions." + suffix)
                    if suffix == "pvsm":
                        simple.SaveState(path)
                        simple.ResetSession()
                        simple.LoadState(path)
                    else:
                        state = smstate.get_state()
                        simple.ResetSession()
                        exec(compile(state, path, "exec"), {})
                    (source,) = simple.GetSources().values()
                    loaded = simple.GetRepresentation(source, simple.GetActiveView())
                    self.assertEqual(kind, loaded.Representation)
                    for name, value in given.items():
                        now = loaded.GetProperty(name).GetData()
                        if hasattr(now, "__len__") and not isinstance(now, str):
                            self.assertLess(numpy.abs(numpy.subtract(list(now), value)).max(), 1e-12, name)
                        else:
                            self.assertEqual(value, now, name)

    @staticmethod
    def own_properties():
        root = ElementTree.parse(PLUGIN_XML).getroot()
        names = set()
        for proxy in root.iter():
            if proxy.get("name") in (
                    "TreeAMRRepresentation", "TreeAMRVolumeRepresentation", "TreeAMRIsosurfaceRepresentation"):
                names |= {scene.of_display(child.get("name")) for child in proxy if child.tag.endswith("VectorProperty") and
                          child.get("is_internal") != "1" and child.get("information_only") != "1"}
        return names - {"Visibility", "ForceUseCache", "ForcedCacheKey", "ColorArrayName"}

    def test_information(self):
        """Of the last picture: cells, levels, memory, samples and seconds."""
        self.show("Tree AMR Volume")
        simple.Render(self.view)
        self.representation.UpdatePropertyInformation()
        get = lambda name: self.representation.GetProperty(name).GetData()
        self.assertEqual(288, get("DrawnCells"))
        self.assertEqual(2, get("DrawnLevels"))
        self.assertGreater(get("FrameSamples"), 1000)
        self.assertGreater(get("Memory"), 0)
        self.assertLess(get("Memory"), 1)
        self.assertGreater(get("FrameSeconds"), 0)

    def test_progress(self):
        """Still frames that take long tell how far they are."""
        for kind in KINDS:
            with self.subTest(kind=kind):
                simple.ResetSession()
                self.show(kind)
                if kind == "Tree AMR Volume":
                    self.representation.SamplesPerCell = 200
                else:
                    self.representation.AmbientOcclusionSamples = 250
                simple.Render(self.view)
                handler = servermanager.ActiveConnection.Session.GetProgressHandler()
                handler.SetProgressInterval(0)
                texts = []
                tag = handler.AddObserver(
                    "ProgressEvent", lambda *_: texts.append((handler.GetLastProgressText(), handler.GetLastProgress())))
                # Until it is long on this machine.
                for size in (500, 1000, 2000, 4000):
                    self.view.ViewSize = [size, size]
                    simple.Render(self.view)
                    told = [t for t in texts if "TreeAMR" in t[0] and 0 < t[1] < 100]
                    if len(told) > 1:
                        break
                handler.RemoveObserver(tag) # before anything fails: it outlives this session
                self.assertGreater(len(told), 1, texts)

    def test_what_panels_show(self):
        """Surface's properties that these representations do nothing with are hidden from their panels."""
        root = ElementTree.parse(PLUGIN_XML).getroot()
        for kind, proxy in zip(KINDS, ("TreeAMRVolumeRepresentation", "TreeAMRIsosurfaceRepresentation")):
            (definition,) = [p for p in root.iter() if p.get("name") == proxy and p.tag.endswith("RepresentationProxy")]
            hidden = set()
            for decorator in definition.iter("PanelDecorator"):
                tests = list(decorator)
                if len(tests) == 1 and tests[0].get("property") == "Representation":
                    hidden |= set(decorator.get("properties").split())
            manager = servermanager.vtkSMProxyManager.GetProxyManager().GetActiveSessionProxyManager()
            surface = manager.GetPrototypeProxy("representations", "SurfaceRepresentation")
            panel = manager.GetPrototypeProxy("representations", "HyperTreeGridRepresentation")
            visible = set()
            for name in map(scene.of_display, self.names_of(surface)):
                prop = panel.GetProperty(name)
                # Those of blocks have an inspector of their own.
                if name.startswith("Block") or name in ("Assembly", "SelectedBlockSelectors"):
                    continue
                if prop and not prop.GetIsInternal() and not prop.GetInformationOnly() and \
                        prop.GetPanelVisibility() != "never" and name not in hidden:
                    visible.add(name)
            self.assertEqual(SHOWN | (SHOWN_OF_ISOSURFACES if "Isosurface" in kind else set()), visible)

    @staticmethod
    def names_of(proxy):
        iterator = proxy.NewPropertyIterator()
        names = []
        while not iterator.IsAtEnd():
            names.append(iterator.GetKey())
            iterator.Next()
        return names


if __name__ == "__main__":
    scene.main()
