#include "Support/Hexahedra.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCellType.h"
#include "vtkDoubleArray.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkUnstructuredGrid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

namespace treeamr::test
{

namespace
{

/// VTK_HEXAHEDRON's corners as octants, x fastest; and turned by a quarter about z.
constexpr std::array<std::array<int, 8>, 2> hexahedronCorners{ { { 0, 1, 3, 2, 4, 5, 7, 6 },
  { 1, 3, 2, 0, 5, 7, 6, 4 } } };

} // namespace

double hashOf(int number, int component)
{
  std::uint32_t h = 3u * static_cast<std::uint32_t>(number) + static_cast<std::uint32_t>(component);
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  return (h ^ h >> 13) / 3.;
}

void addNumbers(vtkCellData* data, const std::vector<int>& numbers)
{
  vtkNew<vtkIntArray> array;
  array->SetName("number");
  vtkNew<vtkDoubleArray> hashes;
  hashes->SetName("hash");
  hashes->SetNumberOfComponents(3);
  hashes->SetComponentName(1, "second");
  for (const int number : numbers)
  {
    array->InsertNextValue(number);
    hashes->InsertNextTuple3(hashOf(number, 0), hashOf(number, 1), hashOf(number, 2));
  }
  data->AddArray(array);
  data->AddArray(hashes);
}

vtkSmartPointer<vtkUnstructuredGrid> makeHexahedra(
  const std::vector<CellId>& cells, const HexahedronExport& options)
{
  std::vector<int> order(cells.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(options.seed);
  for (int i = 0; i < options.duplicates; ++i)
  {
    order.push_back(static_cast<int>(random() % cells.size()));
  }
  if (options.seed != 0)
  {
    std::shuffle(order.begin(), order.end(), random);
  }

  vtkNew<vtkPoints> points;
  points->SetDataType(options.floats ? VTK_FLOAT : VTK_DOUBLE);
  vtkNew<vtkDoubleArray> x;
  x->SetName("x");
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->Allocate(static_cast<vtkIdType>(order.size()));
  std::map<std::array<double, 3>, vtkIdType> known;
  for (const int number : order)
  {
    const CellId& cell = cells[number];
    std::array<vtkIdType, 8> ids; // by octant
    for (int o = 0; o < 8; ++o)
    {
      std::array<double, 3> p;
      for (int a = 0; a < 3; ++a)
      {
        const double side = sideOf(o, a);
        const double at = 0.5 + (side - 0.5) * options.scale;
        p[a] = options.origin[a] +
          (static_cast<double>(cell.index[a]) + at) * std::ldexp(options.rootSize[a], -cell.level);
      }
      const auto found = options.sharedPoints ? known.find(p) : known.end();
      ids[o] = found != known.end() ? found->second : points->InsertNextPoint(p.data());
      if (options.sharedPoints)
      {
        known[p] = ids[o];
      }
    }
    std::array<vtkIdType, 8> list = ids;
    if (!options.voxels)
    {
      const auto& corners = hexahedronCorners[options.seed != 0 ? random() % 2 : 0];
      std::ranges::transform(corners, list.begin(), [&](int o) { return ids[o]; });
    }
    grid->InsertNextCell(options.voxels ? VTK_VOXEL : VTK_HEXAHEDRON, 8, list.data());
  }
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i)
  {
    x->InsertNextValue(points->GetPoint(i)[0]);
  }
  if (options.voxels)
  {
    grid->GetCells()->ConvertTo32BitStorage();
  }
  addNumbers(grid->GetCellData(), order);
  grid->GetPointData()->AddArray(x);
  return grid;
}

} // namespace treeamr::test
