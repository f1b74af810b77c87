// Octrees' leaves as the hexahedra of unstructured grids, as writers of simulations leave them.
#pragma once

#include "Octree/RootGrid.h"

#include "vtkSmartPointer.h"

#include <array>
#include <cstdint>
#include <vector>

class vtkCellData;
class vtkUnstructuredGrid;

namespace treeamr::test
{

struct HexahedronExport
{
  std::array<double, 3> origin{ 0., 0., 0. };
  std::array<double, 3> rootSize{ 1., 1., 1. };
  bool sharedPoints = false;
  bool floats = false;    // coordinates are rounded to float
  bool voxels = false;    // of ids of 32 bits; else hexahedra whose corners begin anywhere
  double scale = 1.;      // shrunk about the centres
  std::uint32_t seed = 0; // of the order of cells; 0: as they come
  int duplicates = 0;     // cells that come twice
};

/// "number" (int), and "hash" (double, 3 components) that belongs to it.
void addNumbers(vtkCellData* data, const std::vector<int>& numbers);
/// Component of "hash".
double hashOf(int number, int component);

/// With numbers, the places in the list; point array "x" (double) is the coordinate.
vtkSmartPointer<vtkUnstructuredGrid> makeHexahedra(
  const std::vector<CellId>& cells, const HexahedronExport& options);

} // namespace treeamr::test
