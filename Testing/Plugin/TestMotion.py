"""Frames while the camera moves, and the still one after: ParaView's own way, by its interactor, and VTK's."""

import numpy
from paraview import simple
from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkVolume
from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor
import vtkmodules.vtkRenderingOpenGL2

import scene
from treeamr.vtkTreeAMRReader import vtkTreeAMRExampleSource
from treeamr.vtkTreeAMRRendering import vtkTreeAMRVolumeMapper

NEVER = 1e-9  # seconds: every interactive frame has as few rays as allowed


def statistic(renderer, name):
    table = renderer.GetVolumes().GetItemAsObject(0).GetMapper().GetStatistics()
    return table.GetValueByName(0, name).ToDouble()


class TestMotion(scene.TestCase):
    def show(self):
        source = simple.TreeAMRExample(Dataset="Mandelbulb", MinimumLevel=2, MaximumLevel=5)
        self.view = scene.view()
        self.representation = simple.Show(source, self.view)
        simple.ColorBy(self.representation, ("CELLS", "mandelbulb"))
        self.representation.SetRepresentationType("Tree AMR Volume")
        self.representation.InteractiveRenderTime = NEVER
        scene.look(self.view)
        simple.Render(self.view)

    def expect(self, distance, level_of_detail):
        renderer = self.view.GetRenderer()
        self.assertEqual(distance, statistic(renderer, "ImageSampleDistance"))
        self.assertEqual(level_of_detail, statistic(renderer, "LevelOfDetail"))

    def test_defaults_are_those_of_the_mapper(self):
        self.show()
        mapper = vtkTreeAMRVolumeMapper()
        for name in ("AutoAdjustSampleDistances", "ImageSampleDistance", "MinimumImageSampleDistance",
                     "MaximumImageSampleDistance", "LevelOfDetail", "ShowIsosurfaces", "IsosurfaceOpacityScale",
                     "AmbientOcclusionSamples", "AmbientOcclusionRadius", "Shadows"):
            self.assertEqual(getattr(mapper, "Get" + name)(), getattr(self.representation, name), name)

    def test_interactive_and_still_renders(self):
        self.show()
        still = scene.shown(self.view.GetRenderWindow())
        self.expect(1, 0)
        self.view.SMProxy.InteractiveRender()
        self.expect(10, 2)
        draft = scene.shown(self.view.GetRenderWindow())
        self.assertFalse((draft == still).all())
        self.view.SMProxy.StillRender()
        self.expect(1, 0)
        self.assertTrue((scene.shown(self.view.GetRenderWindow()) == still).all())

    def test_properties(self):
        self.show()
        self.representation.MaximumImageSampleDistance = 3
        self.representation.LevelOfDetail = 0.5
        self.view.SMProxy.InteractiveRender()
        self.expect(3, 0.5)
        self.representation.MinimumImageSampleDistance = 2
        self.representation.InteractiveRenderTime = 1e6
        self.view.SMProxy.InteractiveRender()
        self.expect(2, 0.5)
        simple.Render(self.view)
        self.expect(2, 0)
        self.representation.AutoAdjustSampleDistances = 0
        self.representation.ImageSampleDistance = 4
        self.view.SMProxy.InteractiveRender()
        self.expect(4, 0)
        simple.Render(self.view)
        self.expect(4, 0)

    def test_draft_resembles_the_still_image(self):
        """A tenth of the rays; scrambled or moved by a few pixels it would be several times as far off."""
        self.show()
        self.representation.LevelOfDetail = 1
        self.representation.MaximumImageSampleDistance = 3
        still = scene.shown(self.view.GetRenderWindow())
        self.view.SMProxy.InteractiveRender()
        draft = scene.shown(self.view.GetRenderWindow())
        difference = numpy.abs(draft - still).mean()
        shifted = numpy.abs(numpy.roll(still, 3, axis=1) - still).mean()
        print("mean differences: draft", difference, "shifted", shifted)
        self.assertLess(difference, 0.5 * shifted)

    def test_screenshots_are_still(self):
        self.show()
        before = scene.picture(self.view, "motion-before")
        self.view.SMProxy.InteractiveRender()
        self.assertTrue(scene.close((before, scene.picture(self.view, "motion-after"))))

    def test_paraview_interactor(self):
        """The events of a drag in the GUI: draft frames, and the still one when the button is released."""
        self.show()
        self.view.MakeRenderWindowInteractor(True)
        interactor = self.view.GetInteractor()
        interactor.InvokeEvent("StartInteractionEvent")
        interactor.InvokeEvent("InteractionEvent")
        interactor.InvokeEvent("RenderEvent")
        self.expect(10, 2)
        interactor.InvokeEvent("EndInteractionEvent")
        self.expect(1, 0)

    def test_vtk_interactor(self):
        """A drag in a program that uses VTK alone."""
        source = vtkTreeAMRExampleSource()
        source.SetDatasetToSynthetic()
        mapper = vtkTreeAMRVolumeMapper()
        mapper.SetInputConnection(source.GetOutputPort())
        mapper.SetInteractiveRenderTime(NEVER)
        volume = vtkVolume()
        volume.SetMapper(mapper)
        renderer = vtkRenderer()
        renderer.AddVolume(volume)
        window = vtkRenderWindow()
        window.OffScreenRenderingOn()
        window.SetSize(60, 44)
        window.AddRenderer(renderer)
        interactor = vtkGenericRenderWindowInteractor()
        interactor.SetRenderWindow(window)
        interactor.SetInteractorStyle(vtkInteractorStyleTrackballCamera())
        interactor.Initialize()
        distances = []
        mapper.AddObserver("VolumeMapperRenderEndEvent", lambda *_: distances.append(
            statistic(renderer, "ImageSampleDistance")))
        window.Render()
        interactor.SetEventInformation(30, 20)
        interactor.LeftButtonPressEvent()
        for x in (34, 38):
            interactor.SetEventInformation(x, 20)
            interactor.MouseMoveEvent()
        interactor.LeftButtonReleaseEvent()
        self.assertEqual([1, 10, 10, 1], distances)


if __name__ == "__main__":
    scene.main()
