// Random grids through the public interface of VTK alone.
#include "Support/HyperTreeGrids.h"

#include "Octree/TreePath.h"

#include "vtkBitArray.h"
#include "vtkCallbackCommand.h"
#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkUniformHyperTreeGrid.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace treeamr::test
{

namespace
{

/// The same numbers with every standard library, which std::uniform_real_distribution does not promise.
class Random
{
public:
  explicit Random(std::uint32_t seed)
    : engine_(seed)
  {
  }
  double uniform() { return engine_() / 4294967296.; }
  bool chance(double probability) { return uniform() < probability; }

private:
  std::mt19937 engine_;
};

void refineRandomly(vtkHyperTree* tree, vtkIdType vertex, unsigned int level, double probability,
  unsigned int levels, Random& random)
{
  if (level >= levels || !random.chance(probability))
  {
    return;
  }
  tree->SubdivideLeaf(vertex, level);
  for (int o = 0; o < 8; ++o)
  {
    refineRandomly(tree, tree->GetElderChildIndex(static_cast<unsigned int>(vertex)) + o, level + 1,
      probability, levels, random);
  }
}

void setCoordinates(vtkHyperTreeGrid* grid, const std::array<int, 3>& roots, int mirrored)
{
  for (int a = 0; a < 3; ++a)
  {
    vtkNew<vtkDoubleArray> planes;
    double x = -1. + a;
    for (int i = 0; i <= roots[a]; ++i)
    {
      planes->InsertNextValue(mirrored >> a & 1 ? -x : x);
      x += 0.75 + 0.25 * ((i + a) % 3);
    }
    a == 0     ? grid->SetXCoordinates(planes)
      : a == 1 ? grid->SetYCoordinates(planes)
               : grid->SetZCoordinates(planes);
  }
}

/// Each tree gets the next part of 0, 1, 2 ..., shuffled over the whole grid when explicit.
vtkIdType numberVertices(vtkHyperTreeGrid* grid, bool explicitIndices, std::uint32_t seed)
{
  vtkIdType count = 0;
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  while (vtkHyperTree* tree = iterator.GetNextTree())
  {
    if (!explicitIndices)
    {
      tree->SetGlobalIndexStart(count);
    }
    count += tree->GetNumberOfVertices();
  }
  if (!explicitIndices)
  {
    return count;
  }
  std::vector<vtkIdType> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  std::shuffle(indices.begin(), indices.end(), std::mt19937(seed));
  count = 0;
  grid->InitializeTreeIterator(iterator);
  while (vtkHyperTree* tree = iterator.GetNextTree())
  {
    for (vtkIdType v = 0; v < tree->GetNumberOfVertices(); ++v)
    {
      tree->SetGlobalIndexFromLocal(v, indices[count++]);
    }
  }
  return count;
}

void addRandomArrays(vtkHyperTreeGrid* grid, vtkIdType count, double notFinite, Random& random)
{
  vtkNew<vtkDoubleArray> scalar;
  scalar->SetName("scalar");
  vtkNew<vtkFloatArray> vector;
  vector->SetName("vector");
  vector->SetNumberOfComponents(3);
  vtkNew<vtkIntArray> number;
  number->SetName("count");
  for (vtkIdType i = 0; i < count; ++i)
  {
    double value = 2. * random.uniform() - 1.;
    if (random.chance(notFinite))
    {
      value = i % 3 == 0 ? std::numeric_limits<double>::quiet_NaN()
        : i % 3 == 1     ? -std::numeric_limits<double>::infinity()
                         : 1e300; // beyond float
    }
    scalar->InsertNextValue(value);
    vector->InsertNextTuple3(
      2. * random.uniform() - 1., 2. * random.uniform() - 1., 2. * random.uniform() - 1.);
    number->InsertNextValue(static_cast<int>(1000. * random.uniform()));
  }
  grid->GetCellData()->AddArray(scalar);
  grid->GetCellData()->AddArray(vector);
  grid->GetCellData()->AddArray(number);
}

void addRandomGhosts(vtkHyperTreeGrid* grid, vtkIdType count, double probability, Random& random)
{
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType i = 0; i < count; ++i)
  {
    unsigned char type = random.chance(0.5) ? vtkDataSetAttributes::REFINEDCELL : 0; // without meaning here
    type |= random.chance(probability) ? vtkDataSetAttributes::DUPLICATECELL : 0;
    type |= random.chance(probability) ? vtkDataSetAttributes::HIDDENCELL : 0;
    ghosts->InsertNextValue(type);
  }
  grid->GetCellData()->AddArray(ghosts);
}

bool lessByBounds(const DrawnCell& a, const DrawnCell& b)
{
  return a.bounds < b.bounds;
}

/// Walks a grid whose own depth limit is off.
class CursorWalk
{
public:
  CursorWalk(vtkHyperTreeGrid* grid, const std::string& array, int component, unsigned int depthLimit)
    : array_(grid->GetCellData()->GetArray(array.c_str()))
    , component_(component)
    , ghosts_(grid->GetGhostCells())
    , depthLimit_(depthLimit)
  {
    vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
    grid->InitializeTreeIterator(iterator);
    vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
    vtkIdType id = 0;
    while (iterator.GetNextTree(id))
    {
      grid->InitializeNonOrientedGeometryCursor(cursor, id);
      walk(cursor, nullptr);
    }
  }

  std::vector<DrawnCell> cells;

private:
  struct Merged
  {
    double sum = 0.;
    double volume = 0.;
    bool allGhosts = true;
  };

  double value(vtkIdType index) const
  {
    const int components = array_->GetNumberOfComponents();
    if (components == 1 || component_ >= 0)
    {
      return array_->GetComponent(index, std::max(component_, 0));
    }
    double squares = 0.;
    for (int c = 0; c < components; ++c)
    {
      squares += std::pow(array_->GetComponent(index, c), 2.);
    }
    return std::sqrt(squares);
  }

  void walk(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, Merged* merged)
  {
    if (cursor->IsMasked())
    {
      return;
    }
    DrawnCell cell;
    const double* origin = cursor->GetOrigin();
    const double* size = cursor->GetSize();
    for (int a = 0; a < 3; ++a)
    {
      cell.bounds[a] = std::min(origin[a], origin[a] + size[a]);
      cell.bounds[3 + a] = std::max(origin[a], origin[a] + size[a]);
    }
    if (cursor->IsLeaf())
    {
      const vtkIdType index = cursor->GetGlobalNodeIndex();
      const int ghost = ghosts_ ? ghosts_->GetValue(index) : 0;
      cell.value = value(index);
      cell.ghost = ghost & vtkDataSetAttributes::DUPLICATECELL;
      const bool drawn = !(ghost & vtkDataSetAttributes::HIDDENCELL) &&
        std::abs(cell.value) <= std::numeric_limits<float>::max();
      if (drawn && merged)
      {
        const double volume = std::abs(size[0] * size[1] * size[2]);
        merged->sum += volume * cell.value;
        merged->volume += volume;
        merged->allGhosts = merged->allGhosts && cell.ghost;
      }
      else if (drawn)
      {
        cells.push_back(cell);
      }
      return;
    }
    Merged here;
    const bool atLimit = !merged && cursor->GetLevel() >= depthLimit_;
    for (unsigned char o = 0; o < 8; ++o)
    {
      cursor->ToChild(o);
      walk(cursor, atLimit ? &here : merged);
      cursor->ToParent();
    }
    if (here.volume > 0.)
    {
      cell.value = here.sum / here.volume;
      cell.ghost = here.allGhosts;
      cells.push_back(cell);
    }
  }

  vtkDataArray* array_;
  int component_;
  vtkUnsignedCharArray* ghosts_;
  unsigned int depthLimit_;
};

void collectLeaves(const Field& field, TreePath& path, std::vector<DrawnCell>& cells)
{
  const NodeRef node = path.node();
  if (node.isLeaf())
  {
    const Bounds bounds = field.octree().grid().nodeBounds(path.index(), node.depth());
    DrawnCell& cell = cells.emplace_back();
    std::copy(bounds.min.begin(), bounds.min.end(), cell.bounds.begin());
    std::copy(bounds.max.begin(), bounds.max.end(), cell.bounds.begin() + 3);
    cell.value = field.value(node);
    cell.ghost = field.octree().isGhost(node.index());
  }
  for (int o = 0; node.isInner() && o < 8; ++o)
  {
    if (!field.octree().child(node, o).isNone())
    {
      path.descend(o);
      collectLeaves(field, path, cells);
      path.ascend();
    }
  }
}

} // namespace

vtkSmartPointer<vtkHyperTreeGrid> makeGrid(const RandomHyperTreeGrid& options)
{
  Random random(options.seed);
  vtkSmartPointer<vtkHyperTreeGrid> grid;
  if (options.uniform)
  {
    const auto uniform = vtkSmartPointer<vtkUniformHyperTreeGrid>::New();
    const auto side = [&](int axis) { return options.mirrored >> axis & 1 ? -1. : 1.; };
    uniform->SetOrigin(side(0) * -1., side(1) * 2., side(2) * 0.5);
    uniform->SetGridScale(side(0) * 0.5, side(1) * 1.25, side(2) * 2.);
    grid = uniform;
  }
  else
  {
    grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
    setCoordinates(grid, options.roots, options.mirrored);
  }
  grid->SetBranchFactor(2);
  grid->SetDimensions(options.roots[0] + 1, options.roots[1] + 1, options.roots[2] + 1);
  grid->SetTransposedRootIndexing(options.transposedRoots);
  const vtkIdType rootCount = grid->GetMaxNumberOfTrees();
  for (vtkIdType id = 0; id < rootCount; ++id)
  {
    if (!random.chance(options.missingTrees))
    {
      refineRandomly(grid->GetTree(id, true), 0, 0, options.refine, options.levels, random);
    }
  }
  const vtkIdType count = numberVertices(grid, options.explicitIndices, options.seed);
  addRandomArrays(grid, count, options.notFinite, random);
  if (options.ghosts > 0.)
  {
    addRandomGhosts(grid, count, options.ghosts, random);
  }
  if (options.masked > 0.)
  {
    addRandomMask(grid, options.masked, options.seed);
  }
  grid->SetDepthLimiter(options.depthLimit);
  return grid;
}

vtkSmartPointer<vtkHyperTreeGrid> makeUniformlyRefinedGrid(unsigned int level)
{
  const auto grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
  grid->SetBranchFactor(2);
  grid->SetDimensions(2, 2, 2);
  vtkNew<vtkDoubleArray> planes;
  planes->InsertNextValue(0.);
  planes->InsertNextValue(1.);
  grid->SetXCoordinates(planes);
  grid->SetYCoordinates(planes);
  grid->SetZCoordinates(planes);
  Random always(1);
  refineRandomly(grid->GetTree(0, true), 0, 0, 1., level, always);
  const vtkIdType count = numberVertices(grid, false, 0);
  vtkNew<vtkDoubleArray> scalar;
  scalar->SetName("scalar");
  for (vtkIdType i = 0; i < count; ++i)
  {
    scalar->InsertNextValue(static_cast<double>(i + 1));
  }
  grid->GetCellData()->AddArray(scalar);
  return grid;
}

vtkSmartPointer<vtkPolyData> randomPoints(const std::array<double, 6>& bounds, int count)
{
  std::mt19937 engine(7);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int i = 0; i < count; ++i)
  {
    std::array<double, 3> p;
    for (int a = 0; a < 3; ++a)
    {
      p[a] = bounds[2 * a] + (bounds[2 * a + 1] - bounds[2 * a]) * (engine() / 4294967296.);
    }
    points->InsertNextPoint(p.data());
  }
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  return data;
}

vtkIdType countVertices(vtkHyperTreeGrid* grid)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  return grid->GetNumberOfCells();
#else
  return grid->GetNumberOfVertices();
#endif
}

void addRandomMask(vtkHyperTreeGrid* grid, double probability, std::uint32_t seed)
{
  Random random(seed + 1000);
  const vtkIdType count = grid->GetGlobalNodeIndexMax() + 1;
  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfTuples(count);
  for (vtkIdType i = 0; i < count; ++i)
  {
    mask->SetValue(i, random.chance(probability));
  }
  grid->SetMask(mask);
}

std::array<double, 6> latticeBounds(vtkHyperTreeGrid* grid)
{
  std::array<double, 6> bounds;
  vtkDataArray* const planes[]{ grid->GetXCoordinates(), grid->GetYCoordinates(), grid->GetZCoordinates() };
  for (int a = 0; a < 3; ++a)
  {
    planes[a]->GetRange(&bounds[2 * a]);
  }
  return bounds;
}

std::vector<DrawnCell> drawnCells(vtkHyperTreeGrid* grid, const std::string& array, int component)
{
  const unsigned int depthLimit = grid->GetDepthLimiter();
  grid->SetDepthLimiter(std::numeric_limits<unsigned int>::max());
  CursorWalk walk(grid, array, component, depthLimit);
  grid->SetDepthLimiter(depthLimit);
  std::sort(walk.cells.begin(), walk.cells.end(), lessByBounds);
  return std::move(walk.cells);
}

std::vector<DrawnCell> drawnCells(const Field& field)
{
  std::vector<DrawnCell> cells;
  TreePath path(field.octree());
  collectLeaves(field, path, cells);
  std::sort(cells.begin(), cells.end(), lessByBounds);
  return cells;
}

void forEachLeaf(vtkHyperTreeGrid* grid, const std::function<void(const double*, vtkIdType)>& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
  grid->InitializeTreeIterator(trees);
  vtkIdType tree = 0;
  while (trees.GetNextTree(tree))
  {
    vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
    grid->InitializeNonOrientedGeometryCursor(cursor, tree);
    const std::function<void()> walk = [&] {
      if (cursor->IsMasked())
      {
        return;
      }
      if (cursor->IsLeaf())
      {
        double bounds[6];
        cursor->GetBounds(bounds);
        visit(bounds, cursor->GetGlobalNodeIndex());
        return;
      }
      for (unsigned char o = 0; o < 8; ++o)
      {
        cursor->ToChild(o);
        walk();
        cursor->ToParent();
      }
    };
    walk();
  }
}

MessageCatcher::MessageCatcher(vtkObject* object, unsigned long event)
  : object_(object)
{
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(&messages_);
  command->SetCallback([](vtkObject*, unsigned long, void* clientData, void* callData) {
    static_cast<std::vector<std::string>*>(clientData)->emplace_back(static_cast<const char*>(callData));
  });
  observer_ = object->AddObserver(event, command);
}

MessageCatcher::~MessageCatcher()
{
  object_->RemoveObserver(observer_);
}

} // namespace treeamr::test
