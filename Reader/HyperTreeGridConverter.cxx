// The cache of fields and octrees in front of the conversion.
#include "HyperTreeGridConverter.h"

#include "GridPartition.h"

#include "CategoryNumbers.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkMath.h"

#include <oneapi/tbb/task_arena.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <sstream>

namespace treeamr
{

namespace
{

/// What a field was made from. The values themselves: one may change them in place and mark the grid alone as
/// modified, as VTK's own mappers see it.
struct FieldKey
{
  ContentDigest topology;
  ContentDigest globalIndices;
  ContentDigest values;
  int component;

  auto operator<=>(const FieldKey&) const = default;
};

class FieldCache
{
public:
  std::shared_ptr<const Field> acquireField(HyperTreeGridTopology& topology, const CellValues& values)
  {
    return acquire(fields_, topology, values, [&](const ContentDigest& octreeKey) {
      if (values.isAtCorners())
      {
        return buildOfCorners(topology, octreeKey, values);
      }
      Field field = build(topology, octreeKey, values);
      checkDigits(field, values);
      return values.array().GetDataType() == VTK_FLOAT ? std::move(field)
                                                       : withOffset(std::move(field), topology, values);
    });
  }

  std::shared_ptr<const Categories> acquireCategories(
    HyperTreeGridTopology& topology, const CellValues& values)
  {
    return acquire(categories_, topology, values, [&](const ContentDigest& octreeKey) {
      const CategoryNumbers numbers(topology, values);
      return Categories{ build(topology, octreeKey, numbers), arrayOf(numbers.categories(), values) };
    });
  }

  std::shared_ptr<const Octree> acquireOctree(const HyperTreeGridTopology& topology)
  {
    checkCells(topology);
    const ContentDigest key = topology.octreeDigest();
    const std::scoped_lock lock(mutex_);
    std::weak_ptr<const Octree>& cached = octrees_[key];
    std::shared_ptr<const Octree> octree = cached.lock();
    if (!octree)
    {
      tbb::this_task_arena::isolate([&] { // as below
        octree = octreeOf(topology);
      });
      cached = octree;
    }
    return octree;
  }

private:
  /// Floats tell of an offset what they have digits for, 24 of the 53 or 64 bits at a time.
  static constexpr int offsetRounds = 3;

  template <class Made>
  using Entries = std::map<FieldKey, std::weak_ptr<const Made>>;

  /// One caller builds at a time. The others wait for the lock and find the result. build: from the octree's key.
  template <class Made, class Build>
  std::shared_ptr<const Made> acquire(
    Entries<Made>& entries, HyperTreeGridTopology& topology, const CellValues& values, const Build& build)
  {
    const FieldKey key{ topology.octreeDigest(), topology.globalIndexDigest(), values.digest(),
      values.component() };
    const std::scoped_lock lock(mutex_);
    std::erase_if(octrees_, [](const auto& entry) { return entry.second.expired(); });
    std::erase_if(entries, [](const auto& entry) { return entry.second.expired(); });

    std::shared_ptr<const Made> found;
    if (const auto at = entries.find(key); at != entries.end())
    {
      found = at->second.lock();
    }
    if (found)
    {
      return found;
    }
    // Without isolation this thread, waiting for its workers, could start a task of somebody else that comes
    // here again and would wait for the lock that this thread holds.
    tbb::this_task_arena::isolate(
      [&] { found = std::make_shared<const Made>(build(cutNonFinite(topology, key.topology, values))); });
    entries[key] = found;
    return found;
  }

  /// The key of the octree that is left.
  static ContentDigest cutNonFinite(
    HyperTreeGridTopology& topology, ContentDigest octreeKey, const CellValues& values)
  {
    checkCells(topology);
    std::atomic<bool> anyFinite{ false }; // of those left out, too large for float
    std::atomic<bool> anyInfinite{ false };
    const auto isKept = [&](vtkIdType index) {
      if (values.isFinite(index))
      {
        return true;
      }
      if (const double value = values(index); !std::isnan(value))
      {
        (std::isinf(value) ? anyInfinite : anyFinite).store(true, std::memory_order_relaxed);
      }
      return false;
    };
    if (topology.excludeNonFinite(isKept))
    {
      octreeKey = topology.octreeDigest();
    }
    if (!topology.hasCells())
    {
      std::ostringstream message;
      message << "hyper tree grid: no cell has a finite value in array '" << values.array().GetName() << "'";
      if (anyFinite)
      {
        constexpr float most = std::numeric_limits<float>::max();
        message << " within single precision, " << -most << " to " << most
                << "; values are beyond it: multiply them by a constant";
      }
      throw NoFiniteValue(message.str(), !anyFinite && !anyInfinite);
    }
    return octreeKey;
  }

  /// Of doubles below the normal numbers of float little or nothing is left.
  static void checkDigits(const Field& field, const CellValues& values)
  {
    constexpr float least = std::numeric_limits<float>::min();
    if (values.array().GetDataType() != VTK_DOUBLE || field.range().min <= -least ||
      field.range().max >= least)
    {
      return;
    }
    std::array<double, 2> range{};
    values.array().GetFiniteRange(range.data(), values.component());
    const double largest = std::max(std::abs(range[0]), std::abs(range[1]));
    if (largest > 0. && largest < least)
    {
      std::ostringstream message;
      message << "hyper tree grid: the values of array '" << values.array().GetName() << "' are at most "
              << largest << "; allowed are " << least
              << " and more, the range of single precision: multiply them by a constant";
      throw Error(message.str());
    }
  }

  /// The field itself where floats hold its digits, else the same less an offset.
  static Field withOffset(Field field, const HyperTreeGridTopology& topology, const CellValues& values)
  {
    const auto rangeOf = [&](const Field& of) { return values.wholeRange(of.offset()).value_or(of.range()); };
    if (const Range range = rangeOf(field); range.min == range.max)
    {
      // One value, of which float may have all digits.
      std::atomic<bool> rounded{ false };
      topology.forEachLeaf([&](vtkIdType index) {
        if (values.less(index, range.min) != 0.)
        {
          rounded.store(true, std::memory_order_relaxed);
        }
      });
      if (!rounded)
      {
        return field;
      }
    }
    for (int i = 0; i < offsetRounds; ++i)
    {
      const Range range = rangeOf(field);
      const double offset = offsetFor(range.min, range.max, field.offset());
      if (offset == field.offset())
      {
        break;
      }
      const std::shared_ptr<const Octree> octree = field.sharedOctree();
      const RelativeValues relative(values, offset);
      field = Field(octree, gatherLeafValues(*octree, HyperTreeGridSource(topology, relative)), offset,
        values.wholeRange(offset));
    }
    return field;
  }

  static std::shared_ptr<const Octree> octreeOf(const HyperTreeGridTopology& topology)
  {
    const NoValues none;
    return buildOctree(topology.rootGrid(), HyperTreeGridSource<NoValues>(topology, none)).octree;
  }

  Field buildOfCorners(
    HyperTreeGridTopology& topology, const ContentDigest& octreeKey, const CellValues& values)
  {
    using Source = HyperTreeGridSource<CellValues>;
    std::weak_ptr<const Octree>& cached = octrees_[octreeKey];
    std::shared_ptr<const Octree> octree = cached.lock();
    if (!octree)
    {
      octree = octreeOf(topology);
      cached = octree;
    }
    const Source source(topology, values);
    LargeVector<Source::Handle> leaves(octree->leafCount());
    forEachLeaf(
      *octree, source, [&](std::uint64_t leaf, const Source::Handle& handle) { leaves[leaf] = handle; });
    const auto withOffset = [&](double offset) {
      return Field::ofCorners(
        octree, [&](std::uint64_t leaf) { return source.corners(leaves[leaf], offset); }, offset);
    };
    Field field = withOffset(0.);
    checkDigits(field, values);
    for (int i = 0; i < offsetRounds && values.array().GetDataType() != VTK_FLOAT; ++i)
    {
      const double offset = offsetFor(field.range().min, field.range().max, field.offset());
      if (offset == field.offset())
      {
        break;
      }
      field = withOffset(offset);
    }
    return field;
  }

  static void checkCells(const HyperTreeGridTopology& topology)
  {
    if (!topology.hasCells())
    {
      throw NoCells("hyper tree grid: all cells are masked or hidden");
    }
  }

  template <class Values>
  Field build(HyperTreeGridTopology& topology, const ContentDigest& octreeKey, const Values& values)
  {
    const HyperTreeGridSource<Values> source(topology, values);
    std::weak_ptr<const Octree>& cached = octrees_[octreeKey];
    if (std::shared_ptr<const Octree> octree = cached.lock())
    {
      treeamr::LargeVector<float> leafValues = gatherLeafValues(*octree, source);
      return Field(std::move(octree), std::move(leafValues), 0., wholeRange(values));
    }
    OctreeAndValues built = buildOctree(topology.rootGrid(), source);
    cached = built.octree;
    return Field(std::move(built.octree), std::move(built.values), 0., wholeRange(values));
  }
  static std::optional<Range> wholeRange(const CellValues& values) { return values.wholeRange(0.); }
  template <class Values>
  static std::optional<Range> wholeRange(const Values& /*values*/)
  {
    return std::nullopt; // of numbers that this process counts
  }

  static vtkSmartPointer<vtkDataArray> arrayOf(const std::vector<double>& numbers, const CellValues& values)
  {
    const int type = values.array().GetDataType();
    const auto array =
      vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(values.component() < 0 ? VTK_DOUBLE
          : type == VTK_BIT ? VTK_UNSIGNED_CHAR // VTK looks no bits up
                            : type));
    array->SetNumberOfTuples(static_cast<vtkIdType>(numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); ++i)
    {
      array->SetComponent(static_cast<vtkIdType>(i), 0, numbers[i]);
    }
    return array;
  }

  std::mutex mutex_;
  std::map<ContentDigest, std::weak_ptr<const Octree>> octrees_;
  Entries<Field> fields_;
  Entries<Categories> categories_;
};

/// For the whole process.
FieldCache& fieldCache()
{
  static FieldCache cache;
  return cache;
}

} // namespace

std::shared_ptr<const Field> acquireField(vtkHyperTreeGrid* grid, const ArraySelection& selection)
{
  HyperTreeGridTopology topology(grid);
  const CellValues values(*grid, selection, topology.globalIndexEnd());
  return fieldCache().acquireField(topology, values);
}

std::shared_ptr<const Categories> acquireCategories(vtkHyperTreeGrid* grid, const ArraySelection& selection)
{
  HyperTreeGridTopology topology(grid);
  const CellValues values(*grid, selection, topology.globalIndexEnd());
  return fieldCache().acquireCategories(topology, values);
}

std::shared_ptr<const Octree> acquireOctree(vtkHyperTreeGrid* grid)
{
  return fieldCache().acquireOctree(HyperTreeGridTopology(grid));
}

vtkIdType globalIndex(vtkHyperTreeGrid& grid, const CellId& cell)
{
  const auto noCell = [&] {
    return Error("hyper tree grid: it has no cell (" + std::to_string(cell.index[0]) + ", " +
      std::to_string(cell.index[1]) + ", " + std::to_string(cell.index[2]) + ") of level " +
      std::to_string(cell.level));
  };
  std::array<unsigned int, 3> roots;
  grid.GetCellDims(roots.data());
  HyperTreeView tree;
  tree.turned = turnedAxes(grid);
  std::array<unsigned int, 3> root;
  for (int a = 0; a < 3; ++a)
  {
    const Coord place = cell.index[a] >> cell.level;
    if (place < 0 || place >= static_cast<Coord>(roots[a]))
    {
      throw noCell();
    }
    root[a] = static_cast<unsigned int>(turnedRoot(place, roots[a], tree.turned >> a & 1));
  }
  vtkIdType treeId = 0;
  grid.GetIndexFromLevelZeroCoordinates(treeId, root[0], root[1], root[2]);
  tree.tree = grid.GetTree(treeId);
  if (!tree.tree)
  {
    throw noCell();
  }
  tree.vertexCount = tree.tree->GetNumberOfVertices();
  tree.elderChild = tree.tree->GetElderChildIndexArray(tree.elderChildCount);
  vtkIdType vertex = 0;
  for (int up = cell.level - 1; up >= 0; --up)
  {
    if (tree.isLeaf(vertex))
    {
      throw noCell();
    }
    int octant = 0;
    for (int a = 0; a < 3; ++a)
    {
      octant |= static_cast<int>(cell.index[a] >> up & 1) << a;
    }
    vertex = tree.child(vertex, octant);
  }
  return tree.tree->GetGlobalIndexFromLocal(vertex);
}

vtkDataArray& numericCellArray(vtkHyperTreeGrid& grid, const std::string& name)
{
  vtkCellData* cells = grid.GetCellData();
  vtkAbstractArray* found = cells->GetAbstractArray(name.c_str());
  if (vtkDataArray* array = vtkDataArray::SafeDownCast(found))
  {
    return *array;
  }
  if (found)
  {
    throw Error("hyper tree grid: cell array '" + name + "' is a " + found->GetClassName() +
      ", allowed are arrays of numbers");
  }
  std::string names;
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    vtkDataArray* array = cells->GetArray(i); // null when it is not of numbers
    if (array && array->GetName())
    {
      names += (names.empty() ? "'" : ", '") + std::string(array->GetName()) + "'";
    }
  }
  throw Error("hyper tree grid: cell array '" + name + "' does not exist; there are: " +
    (names.empty() ? "none; give the cells an array of numbers" : names + "; select one of them"));
}

void computeLocalBounds(vtkHyperTreeGrid* grid, double bounds[6])
{
  vtkMath::UninitializeBounds(bounds);
  if (!grid)
  {
    return;
  }
  try
  {
    const RootGrid rootGrid(readRootPlanes(*grid));
    for (const HyperTreeView& tree : collectTrees(*grid))
    {
      const Bounds box = rootGrid.nodeBounds(tree.root, rootGrid.paddingDepth());
      const bool first = !vtkMath::AreBoundsInitialized(bounds);
      for (int a = 0; a < 3; ++a)
      {
        bounds[2 * a] = first ? box.min[a] : std::min(bounds[2 * a], box.min[a]);
        bounds[2 * a + 1] = first ? box.max[a] : std::max(bounds[2 * a + 1], box.max[a]);
      }
    }
    if (const auto partition = partitionOf(*grid); partition && vtkMath::AreBoundsInitialized(bounds))
    {
      const Bounds box = partition->box().bounds(rootGrid);
      for (int a = 0; a < 3; ++a)
      {
        bounds[2 * a] = std::max(bounds[2 * a], box.min[a]);
        bounds[2 * a + 1] = std::min(bounds[2 * a + 1], box.max[a]);
      }
      if (!vtkMath::AreBoundsInitialized(bounds))
      {
        vtkMath::UninitializeBounds(bounds);
      }
    }
  }
  catch (const Error&)
  {
    vtkMath::UninitializeBounds(bounds); // acquireField() says why
  }
}

} // namespace treeamr
