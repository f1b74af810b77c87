// Saved forests, read into a grid that is converted into an octree. The last byte, which belongs to no quadrant, says how.
#include "FuzzInput.h"

#include "Error.h"
#include "HyperTreeGridConverter.h"
#include "vtkTreeAMRP4estReader.h"

#include "vtkCellData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <array>

using namespace treeamr;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  constexpr std::array payloads = { "", "double value", "int a; short b[3]", "packed char c; double d",
    "float f[2]" };
  const fuzz::HeapWatch watch(size);
  const unsigned options = size > 0 ? data[size - 1] : 0u;
  const std::string folder = fuzz::writeFiles({ { "forest", { data, size } } });
  vtkNew<vtkTreeAMRP4estReader> reader;
  reader->SetFileName((folder + "forest").c_str());
  reader->SetPayload(payloads[options / 2 % payloads.size()]);
  reader->SetGenerateLevel((options & 1) != 0);
  reader->Update();
  vtkHyperTreeGrid* const grid = reader->GetHyperTreeGridOutput();
  fuzz::require(
    (reader->GetErrorCode() == 0) == (grid->GetNumberOfLeaves() > 0), "either an error or a grid");
  if (grid->GetCellData()->GetNumberOfArrays() > 0)
  {
    try
    {
      acquireField(grid, { grid->GetCellData()->GetArrayName(0) });
    }
    catch (const Error&)
    {
      // of what the reader takes and octrees do not
    }
  }
  return 0;
}
