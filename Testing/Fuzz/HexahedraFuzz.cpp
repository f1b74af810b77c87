// Unstructured grids of hexahedra, made into an octree. A byte of options, then the cells, each by eight bytes: its kind and
// level, by how much it is off, and three times two of its place.
#include "FuzzInput.h"

#include "vtkTreeAMRFromUnstructured.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkUnstructuredGrid.h"

#include <cmath>
#include <limits>

using namespace treeamr;

namespace
{

/// Bits of options.
enum Option : unsigned
{
  Voxels = 1,
  Doubles = 2,
  Far = 4, // beside the cells' widths
  Huge = 8
};

/// What a coordinate may be beside one that fits: of the kinds with the highest numbers.
double strayed(double coordinate, unsigned kind, unsigned off, double width)
{
  switch (kind)
  {
    case 12:
      return coordinate + width * (off / 255. - 0.5);
    case 13:
      return coordinate * (1. + off * 1e-7);
    case 14:
      return off % 2 ? std::numeric_limits<double>::infinity() : -coordinate;
    case 15:
      return off % 2 ? std::nan("") : 1e300 * coordinate;
    default:
      return coordinate;
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  constexpr std::size_t lattice = std::size_t(1)
    << 24; // 2^20 roots along an axis, and as many while their list grows
  const fuzz::HeapWatch watch(24 * size, lattice); // 24 coordinates of each cell, which are the file
  fuzz::Bytes bytes{ data, size };
  const unsigned options = bytes.takeByte();
  vtkNew<vtkPoints> points;
  points->SetDataType(options & Doubles ? VTK_DOUBLE : VTK_FLOAT);
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("number");
  vtkNew<vtkDoubleArray> xs; // at points
  xs->SetName("x");
  const double scale = options & Huge ? 1e30 : 1.;
  const double offset = options & Far ? 1e6 : 0.;
  while (bytes.size >= 8)
  {
    const unsigned kind = bytes.takeByte();
    const unsigned off = bytes.takeByte();
    const double width = scale * std::ldexp(1., -static_cast<int>(kind % 16));
    double low[3];
    for (double& coordinate : low)
    {
      const unsigned place = bytes.takeByte();
      coordinate = scale * offset + width * static_cast<int>(place + 256u * bytes.takeByte());
    }
    vtkIdType ids[8];
    for (int corner = 0; corner < 8; ++corner)
    {
      double p[3];
      for (int a = 0; a < 3; ++a)
      {
        p[a] = low[a] + (corner >> a & 1) * width;
      }
      const unsigned axis = off % 3;
      p[axis] = strayed(p[axis], corner == static_cast<int>(off % 8) ? kind / 16 : 0, off, width);
      const int place = options & Voxels || (corner & 2) == 0 ? corner : corner ^ 1;
      ids[place] = points->InsertNextPoint(p);
      xs->InsertNextValue(p[0]);
    }
    grid->InsertNextCell(options & Voxels ? VTK_VOXEL : VTK_HEXAHEDRON, 8, ids);
    numbers->InsertNextValue(static_cast<int>(numbers->GetNumberOfTuples()));
  }
  grid->SetPoints(points);
  grid->GetCellData()->AddArray(numbers);
  grid->GetPointData()->AddArray(xs);
  vtkNew<vtkTreeAMRFromUnstructured> filter;
  filter->SetInputData(grid);
  filter->Update();
  vtkHyperTreeGrid* const output = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
  fuzz::require(output->GetNumberOfLeaves() == 0 || numbers->GetNumberOfTuples() > 0, "no grid of nothing");
  fuzz::require(
    output->GetNumberOfLeaves() == 0 || output->GetCellData()->HasArray("x"), "points' arrays become cells'");
  return 0;
}
