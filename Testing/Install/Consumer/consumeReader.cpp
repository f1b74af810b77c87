// Converts the example data to the core's field through the installed VTK module.
#include "HyperTreeGridConverter.h"

#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkTreeAMRExampleSource.h"

#include <cstdlib>
#include <iostream>

int main()
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  source->Update();
  const auto field = treeamr::acquireField(source->GetHyperTreeGridOutput(), { "xyz" });
  std::cout << field->octree().leafCount() << " leaves\n";
  return field->octree().leafCount() == 288 ? EXIT_SUCCESS : EXIT_FAILURE;
}
