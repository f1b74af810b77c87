// What the processes agree on before cells are sent (CellExchange.h).
#include "GridExchange.h"

#include "CellExchange.h"
#include "CellNumber.h"
#include "CornerArrays.h"
#include "Error.h"
#include "MergedGrid.h"
#include "OwnLeaves.h"
#include "ProcessGroup.h"
#include "SharedArrays.h"
#include "WholeRange.h"

#include "Partition/BoxCuts.h"

#include "vtkCellData.h"
#include "vtkCommunicator.h"
#include "vtkFieldData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkTypeUInt64Array.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <type_traits>

namespace treeamr
{

namespace
{

constexpr const char* originArrayName = "TreeAMROrigin"; // CellNumber's of process and place

ContentDigest digestOf(const std::array<std::vector<double>, 3>& planes)
{
  ContentDigest digest;
  for (const std::vector<double>& axis : planes)
  {
    digest.addBytes(axis.data(), axis.size() * sizeof(double));
  }
  return digest;
}

/// One process, as told to all.
struct Told
{
  bool hasTrees = false;
  bool isPartitioned = false; // for these processes
  ContentDigest boxes;
  ContentDigest lattice;
  std::array<int, 3> roots{};
  unsigned int depthLimit = 0;
  int deepest = 0;
  std::uint64_t leaves = 0;
  ContentDigest content;
};

/// What a process brings.
class LocalGrid
{
public:
  explicit LocalGrid(vtkHyperTreeGrid* grid)
    : grid_(gridsWithTrees(grid).empty() ? nullptr : grid)
  {
  }

  /// Null without trees.
  vtkHyperTreeGrid* grid() const noexcept { return grid_; }
  const HyperTreeGridTopology* topology() const noexcept { return topology_ ? &*topology_ : nullptr; }
  vtkIdType tuples() const noexcept { return topology_ ? topology_->globalIndexEnd() : 0; }

  void tellPartition(const ProcessGroup& group, Told& told) const
  {
    told.hasTrees = grid_ != nullptr;
    if (const auto partition = grid_ ? partitionOf(*grid_) : std::nullopt)
    {
      told.isPartitioned =
        partition->own == group.own() && static_cast<int>(partition->boxes.size()) == group.size();
      told.boxes.add(static_cast<std::uint64_t>(partition->box().level));
      for (const LatticeBox& box : partition->boxes)
      {
        told.boxes.addBytes(&box.begin, sizeof(box.begin));
        told.boxes.addBytes(&box.end, sizeof(box.end));
      }
      told.boxes.add(digestOf(readRootPlanes(*grid_)));
    }
  }

  void tellCells(Told& told)
  {
    if (!grid_)
    {
      return;
    }
    topology_.emplace(grid_);
    told.lattice = digestOf(planes());
    told.roots = topology_->rootGrid().roots();
    told.depthLimit = topology_->depthLimit();
    std::atomic<std::uint64_t> leaves{ 0 };
    std::atomic<int> deepest{ 0 };
    tbb::parallel_for_each(topology_->trees(), [&](const HyperTreeView& tree) {
      std::uint64_t count = 0;
      int level = 0;
      forEachOwnLeaf(*topology_, tree, { tree.root, 0 }, [&](const CellId& place, vtkIdType /*vertex*/) {
        ++count;
        level = std::max(level, place.level);
      });
      leaves += count;
      for (int known = deepest; known < level && !deepest.compare_exchange_weak(known, level);)
      {
      }
    });
    told.leaves = leaves;
    told.deepest = deepest;
  }

  std::array<std::vector<double>, 3> planes() const { return readRootPlanes(*grid_); }

private:
  vtkHyperTreeGrid* grid_;
  std::optional<HyperTreeGridTopology> topology_;
};

class GridExchange
{
public:
  GridExchange(const ProcessGroup& group, vtkHyperTreeGrid* grid)
    : group_(group)
    , given_(grid)
  {
  }

  ExchangedGrid run(const ExchangeOptions& options)
  {
    group_.together([&] {
      local_.emplace(given_);
      local_->tellPartition(group_, told_);
    });
    all_ = group_.gather(told_);
    first_ = static_cast<int>(std::ranges::find(all_, true, &Told::hasTrees) - all_.begin());
    if (first_ == group_.size() || isPartitioned())
    {
      return { given_, {} };
    }
    group_.together([&] { local_->tellCells(told_); });
    all_ = group_.gather(told_);
    checkLattices();
    group_.together([&] { plan(); });
    sharePlanes();
    SharedArrays arrays(group_, local_->grid(), local_->tuples(), first_, options.arrays);
    findCopies(arrays);
    if (options.keepsOrigins)
    {
      group_.together([&] { addOrigins(arrays); });
    }
    cutBoxes();
    ExchangedGrid result;
    result.leftOut = arrays.leftOut();
    result.grid = exchangeCells(group_, plan_, arrays, local_->topology());
    group_.together([&] { finish(arrays, *result.grid); });
    return result;
  }

private:
  bool isPartitioned() const
  {
    return std::ranges::all_of(all_, [this](const Told& told) {
      return !told.hasTrees ||
        (told.isPartitioned && told.boxes == all_[static_cast<std::size_t>(first_)].boxes);
    });
  }

  /// On all processes with the same result.
  void checkLattices() const
  {
    const Told& first = all_[static_cast<std::size_t>(first_)];
    for (std::size_t process = 0; process < all_.size(); ++process)
    {
      if (const Told& told = all_[process]; told.hasTrees && told.lattice != first.lattice)
      {
        const auto textOfRoots = [](const Told& of) {
          return std::to_string(of.roots[0]) + " x " + std::to_string(of.roots[1]) + " x " +
            std::to_string(of.roots[2]);
        };
        throw Error("hyper tree grid of process " + std::to_string(process) + ": its lattice of " +
          textOfRoots(told) + " roots is not that of process " + std::to_string(first_) + ", of " +
          textOfRoots(first) + "; allowed are the same coordinates on all processes");
      }
    }
  }

  void plan()
  {
    plan_.depthLimit = 0;
    for (const Told& told : all_)
    {
      plan_.depthLimit = std::max(plan_.depthLimit, told.depthLimit);
      plan_.deepest = std::max(plan_.deepest, told.deepest);
      plan_.sources.push_back(told.hasTrees ? static_cast<int>(plan_.sources.size()) : -1);
    }
    for (int a = 0; a < 3; ++a)
    {
      plan_.planes[a].resize(static_cast<std::size_t>(all_[static_cast<std::size_t>(first_)].roots[a]) + 1);
    }
    if (group_.own() == first_)
    {
      plan_.planes = local_->planes();
    }
  }

  void sharePlanes()
  {
    for (std::vector<double>& planes : plan_.planes)
    {
      group_.broadcast(planes.data(), planes.size() * sizeof(double), first_);
    }
  }

  /// Sources that ignore what piece is asked of them give each process the same.
  void findCopies(const SharedArrays& arrays)
  {
    const auto hasTwin = [this](const Told& one) {
      return one.hasTrees && std::ranges::count_if(all_, [&](const Told& other) {
        return other.hasTrees && other.leaves == one.leaves;
      }) > 1;
    };
    if (std::ranges::none_of(all_, hasTwin))
    {
      return;
    }
    group_.together([&] {
      if (hasTwin(told_))
      {
        told_.content = local_->topology()->octreeDigest();
        told_.content.add(local_->topology()->globalIndexDigest());
        told_.content.add(arrays.digest());
      }
    });
    all_ = group_.gather(told_);
    for (std::size_t process = 0; process < all_.size(); ++process)
    {
      const Told& told = all_[process];
      const auto same = std::ranges::find_if(all_, [&](const Told& other) {
        return other.hasTrees && other.leaves == told.leaves && other.content == told.content;
      });
      if (hasTwin(told))
      {
        plan_.sources[process] = static_cast<int>(same - all_.begin());
      }
    }
  }

  /// Balanced by cells.
  void cutBoxes()
  {
    const std::array<int, 3> roots = all_[static_cast<std::size_t>(first_)].roots;
    const auto deepest =
      static_cast<int>(std::min<unsigned int>(plan_.depthLimit, static_cast<unsigned int>(plan_.deepest)));
    std::optional<CellHistogram> histogram;
    std::vector<double> sums;
    group_.together([&] {
      histogram.emplace(roots, CellHistogram::levelFor(roots, group_.size(), deepest));
      if (const HyperTreeGridTopology* topology = local_->topology();
          topology && plan_.sources[static_cast<std::size_t>(group_.own())] == group_.own())
      {
        for (const HyperTreeView& tree : topology->trees())
        {
          forEachOwnLeaf(*topology, tree, { tree.root, 0 },
            [&](const CellId& place, vtkIdType /*vertex*/) { histogram->add(place); });
        }
      }
      sums.resize(histogram->counts().size()); // partial ones on the way to the first process
    });
    group_.controller().Reduce(histogram->counts().data(), sums.data(),
      static_cast<vtkIdType>(histogram->counts().size()), vtkCommunicator::SUM_OP, 0);
    // By one process: sums are rounded, and all must have the same boxes.
    GridPartition& partition = plan_.partition;
    group_.together([&] {
      partition.own = group_.own();
      partition.boxes.resize(static_cast<std::size_t>(group_.size()));
      if (group_.own() == 0)
      {
        histogram->counts() = std::move(sums);
        partition.boxes = treeamr::cutBoxes(*histogram, group_.size());
      }
    });
    static_assert(std::is_trivially_copyable_v<LatticeBox>);
    group_.broadcast(partition.boxes.data(), partition.boxes.size() * sizeof(LatticeBox), 0);
  }

  void addOrigins(SharedArrays& arrays) const
  {
    vtkNew<vtkTypeUInt64Array> origins;
    origins->SetName(originArrayName);
    origins->SetNumberOfTuples(local_->tuples());
    for (vtkIdType i = 0; i < local_->tuples(); ++i)
    {
      origins->SetValue(i, CellNumber(static_cast<std::size_t>(group_.own()), i).number());
    }
    arrays.add(*origins);
  }

  void finish(const SharedArrays& arrays, vtkHyperTreeGrid& grid) const
  {
    const auto active = std::ranges::find(arrays.arrays(), true, &SharedArray::isActive);
    grid.GetCellData()->SetActiveScalars(active != arrays.arrays().end() ? active->name.c_str() : nullptr);
    setCornerRanges(grid);
    vtkFieldData* const given = given_ ? given_->GetFieldData() : nullptr;
    for (int i = 0; given && i < given->GetNumberOfArrays(); ++i)
    {
      vtkAbstractArray* const array = given->GetAbstractArray(i);
      if (!array->GetName() || !grid.GetFieldData()->HasArray(array->GetName())) // as its partition before
      {
        grid.GetFieldData()->AddArray(array);
      }
    }
  }

  const ProcessGroup& group_;
  vtkHyperTreeGrid* given_;
  std::optional<LocalGrid> local_;
  Told told_;
  std::vector<Told> all_;
  int first_ = 0; // process with trees
  ExchangePlan plan_;
};

/// Null without origins.
vtkTypeUInt64Array* originsOf(vtkHyperTreeGrid& grid)
{
  return vtkTypeUInt64Array::FastDownCast(grid.GetCellData()->GetAbstractArray(originArrayName));
}

} // namespace

ExchangedGrid exchangeGrid(
  vtkHyperTreeGrid* local, vtkMultiProcessController* controller, const ExchangeOptions& options)
{
  if (!controller || controller->GetNumberOfProcesses() < 2)
  {
    return { local, {} };
  }
  const ProcessGroup group(*controller);
  ExchangedGrid exchanged = GridExchange(group, local).run(options);
  exchanged.grid = withWholeRanges(group, exchanged.grid, options.mayChange || exchanged.grid != local);
  return exchanged;
}

CellOrigin cellOrigin(vtkHyperTreeGrid& grid, vtkIdType index, int own)
{
  vtkTypeUInt64Array* const origins = originsOf(grid);
  if (!origins)
  {
    return { own, index };
  }
  const CellNumber number(origins->GetValue(index));
  return { static_cast<int>(number.block()), number.cell() };
}

vtkIdType largestOrigin(vtkHyperTreeGrid& grid, vtkIdType size)
{
  vtkTypeUInt64Array* const origins = originsOf(grid);
  vtkIdType largest = origins ? 0 : size - 1;
  for (vtkIdType i = 0; origins && i < origins->GetNumberOfTuples(); ++i)
  {
    largest = std::max(largest, CellNumber(origins->GetValue(i)).cell());
  }
  return largest;
}

} // namespace treeamr
