// Makers of vtkHyperTreeGrids for tests, and two lists of their leaves to compare: by VTK's own cursors and
// by the converted octree.
#pragma once

#include "Field/Field.h"

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

class vtkHyperTreeGrid;
class vtkObject;
class vtkPolyData;

namespace treeamr::test
{

struct RandomHyperTreeGrid
{
  std::uint32_t seed = 1;
  std::array<int, 3> roots{ 2, 3, 2 };
  unsigned int levels = 4;       // deepest level
  double refine = 0.5;           // probability that a vertex above the deepest level is refined
  double missingTrees = 0.;      // probability that a root has no tree
  double masked = 0.;            // probability that a vertex, coarse or leaf, is masked
  double ghosts = 0.;            // probability each of DUPLICATECELL and HIDDENCELL, on coarse vertices too
  double notFinite = 0.;         // probability that a value of array "scalar" is NaN or infinite
  bool uniform = false;          // a vtkUniformHyperTreeGrid
  int mirrored = 0;              // mask of axes, as vtkHyperTreeGridAxisReflection leaves them: x becomes -x
  bool transposedRoots = false;  // TransposedRootIndexing
  bool explicitIndices = false;  // a shuffled table of global indices
  unsigned int depthLimit = ~0u; // DepthLimiter
};

/// Roots of unequal sizes, with exact binary fractions as coordinates (equal ones for a uniform grid). Every
/// vertex, coarse ones included, has random values in [-1, 1] in the cell arrays "scalar" (double), "vector"
/// (float, 3 components) and "count" (int, 0 to 999).
vtkSmartPointer<vtkHyperTreeGrid> makeGrid(const RandomHyperTreeGrid& options);

/// A single root over the unit cube, refined everywhere down to a level; "scalar" is 1, 2, 3 ...
vtkSmartPointer<vtkHyperTreeGrid> makeUniformlyRefinedGrid(unsigned int level);

/// Masks vertices, coarse or leaf, at random.
void addRandomMask(vtkHyperTreeGrid* grid, double probability, std::uint32_t seed);

/// Points anywhere in the bounds (xmin, xmax, ymin ...), in double.
vtkSmartPointer<vtkPolyData> randomPoints(const std::array<double, 6>& bounds, int count);

/// Coarse vertices and leaves: GetNumberOfCells(), which VTK 9.1 calls GetNumberOfVertices().
vtkIdType countVertices(vtkHyperTreeGrid* grid);

struct DrawnCell
{
  std::array<double, 6> bounds{}; // xmin, ymin, zmin, xmax, ymax, zmax
  double value = 0.;
  bool ghost = false;
};

/// Of the coordinates, whatever trees there are: xmin, xmax, ymin ... VTK's own GetBounds() is that up to 9.2.
std::array<double, 6> latticeBounds(vtkHyperTreeGrid* grid);

/// What is to be drawn of a grid, found with VTK's cursors, sorted by bounds. component < 0: the magnitude.
std::vector<DrawnCell> drawnCells(vtkHyperTreeGrid* grid, const std::string& array, int component = -1);
/// The leaves of a field's octree, sorted by bounds.
std::vector<DrawnCell> drawnCells(const Field& field);

/// Calls visit(bounds, global index) at each leaf that is not masked; bounds: xmin, xmax, ymin ...
void forEachLeaf(vtkHyperTreeGrid* grid, const std::function<void(const double*, vtkIdType)>& visit);

/// Collects what an object reports with vtkErrorMacro (or vtkWarningMacro) instead of printing it.
class MessageCatcher
{
public:
  /// event: vtkCommand::ErrorEvent or vtkCommand::WarningEvent.
  MessageCatcher(vtkObject* object, unsigned long event);
  ~MessageCatcher();
  MessageCatcher(const MessageCatcher&) = delete;
  MessageCatcher& operator=(const MessageCatcher&) = delete;

  const std::vector<std::string>& messages() const noexcept { return messages_; }

private:
  vtkSmartPointer<vtkObject> object_;
  unsigned long observer_ = 0;
  std::vector<std::string> messages_;
};

} // namespace treeamr::test
