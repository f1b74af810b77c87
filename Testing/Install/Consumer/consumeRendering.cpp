// Draws the example data by the installed mappers in a window that is not shown: a volume and an isosurface.
#include "vtkActor.h"
#include "vtkColorTransferFunction.h"
#include "vtkNew.h"
#include "vtkPiecewiseFunction.h"
#include "vtkProperty.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkTreeAMRExampleSource.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRVolumeMapper.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>

namespace
{

constexpr int size = 200; // pixels along an edge

/// As a PPM; whether something is drawn, and the background beside it.
bool write(vtkProp* prop, const std::string& path)
{
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetSize(size, size);
  window->SetMultiSamples(0);
  window->AddRenderer(renderer);
  renderer->AddViewProp(prop);
  renderer->ResetCamera();
  window->Render();
  vtkNew<vtkUnsignedCharArray> rgb;
  window->GetPixelData(0, 0, size - 1, size - 1, 1, rgb);
  std::ofstream file(path, std::ios::binary);
  file << "P6\n" << size << " " << size << "\n255\n";
  int drawn = 0;
  for (int y = size - 1; y >= 0; --y)
  {
    for (int x = 0; x < size; ++x)
    {
      const unsigned char* const pixel = rgb->GetPointer(3 * (x + size * y));
      file.write(reinterpret_cast<const char*>(pixel), 3);
      drawn += pixel[0] + pixel[1] + pixel[2] > 0;
    }
  }
  std::cout << path << ": " << drawn << " pixels drawn\n";
  return file.good() && drawn > size * size / 10 && drawn < size * size;
}

} // namespace

int main()
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();

  vtkNew<vtkTreeAMRVolumeMapper> volumeMapper;
  volumeMapper->SetInputConnection(source->GetOutputPort());
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0., 0., 0., 1.);
  colors->AddRGBPoint(30., 1., 0.5, 0.);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(0., 0.);
  opacity->AddPoint(30., 0.9);
  vtkNew<vtkVolume> volume;
  volume->SetMapper(volumeMapper);
  volume->GetProperty()->SetColor(colors);
  volume->GetProperty()->SetScalarOpacity(opacity);
  volume->GetProperty()->SetInterpolationTypeToLinear();

  vtkNew<vtkTreeAMRIsosurfaceMapper> surfaceMapper;
  surfaceMapper->SetInputConnection(source->GetOutputPort());
  surfaceMapper->SetValue(0, 6.5);
  surfaceMapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(surfaceMapper);
  actor->GetProperty()->SetColor(0.2, 0.6, 1.);

  const bool hasVolume = write(volume, "vtk-volume.ppm");
  const bool hasSurface = write(actor, "vtk-isosurface.ppm");
  return hasVolume && hasSurface ? EXIT_SUCCESS : EXIT_FAILURE;
}
