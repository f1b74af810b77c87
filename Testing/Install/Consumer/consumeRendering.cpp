// Creates the installed mappers.
#include "vtkNew.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRVolumeMapper.h"

#include <cstdlib>

int main()
{
  vtkNew<vtkTreeAMRVolumeMapper> volume;
  vtkNew<vtkTreeAMRIsosurfaceMapper> isosurface;
  return volume->GetSamplesPerCell() > 0. && isosurface->GetValue(0) == 0. ? EXIT_SUCCESS : EXIT_FAILURE;
}
