// 1. Each cell goes to the processes whose boxes it meets.
// 2. In rounds each process finds out which cells beyond its box the field in it depends on (FieldSupport.h), from those whose
//    boxes these lie in: places are sent, and keys of cells come back.
// 3. The tuples of the cells that are needed are fetched, and the grid is built of all.
#include "CellExchange.h"

#include "CellNumber.h"
#include "Error.h"
#include "GridOfCells.h"
#include "OwnLeaves.h"
#include "ProcessGroup.h"
#include "SharedArrays.h"

#include "Octree/OctreeBuilder.h"
#include "Partition/FieldSupport.h"

#include "vtkCellData.h"
#include "vtkHyperTreeGrid.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

namespace treeamr
{

namespace
{

/// Keys: one of MortonKey.h's, for the padded lattice.
template <class Keys>
class CellExchange
{
public:
  /// All are kept by reference. topology: none where there are no trees.
  CellExchange(const ProcessGroup& group, const ExchangePlan& plan, const SharedArrays& arrays,
    const HyperTreeGridTopology* topology)
    : group_(group)
    , plan_(plan)
    , arrays_(arrays)
    , topology_(topology)
    , roots_(plan.planes)
    , padding_(roots_.paddingDepth())
    , keys_(padding_ + plan.deepest)
    , coarsest_(
        static_cast<int>(std::min<unsigned int>(plan.depthLimit, static_cast<unsigned int>(plan.deepest))))
    , count_(static_cast<std::size_t>(group.size()))
    , support_{ CellSet(padding_), CellSet(padding_) }
  {
  }

  vtkSmartPointer<vtkHyperTreeGrid> run()
  {
    blocks_.resize(2 * count_);
    receiveBox();
    findOutside();
    receiveOutside();
    vtkSmartPointer<vtkHyperTreeGrid> grid;
    group_.together([&] { grid = build(); });
    return grid;
  }

private:
  using Key = typename Keys::Key;
  using Cells = SortedCells<Keys, std::uint64_t>;

  struct Leaf
  {
    Key key;
    vtkIdType index; // in this process' arrays
  };
  using Leaves = std::vector<LargeVector<Leaf>>; // by the process that they go to
  struct Outside
  {
    Key key;
    int owner;
    auto operator<=>(const Outside&) const noexcept = default;
  };

  const LatticeBox& boxOf(int process) const
  {
    return plan_.partition.boxes[static_cast<std::size_t>(process)];
  }
  CellId cellOf(const Key& key) const noexcept
  {
    const int depth = keys_.depth(key);
    return { keys_.index(key, depth), depth - padding_ };
  }
  Key keyOf(const CellId& cell) const noexcept { return keys_.key(cell.index, padding_ + cell.level); }
  static CellId ancestor(CellId cell, int level) noexcept
  {
    for (Coord& index : cell.index)
    {
      index >>= std::max(cell.level - level, 0);
    }
    cell.level = std::min(cell.level, level);
    return cell;
  }
  /// The cell that is drawn of a leaf: that at the depth limit around it.
  CellId drawn(const CellId& leaf) const noexcept { return ancestor(leaf, coarsest_); }

  // 1. The cells that meet the boxes.

  /// Whether this process sends its cells to another one, which takes its own where it has the same.
  bool sendsTo(int process) const
  {
    const int source = plan_.sources[static_cast<std::size_t>(group_.own())];
    return source >= 0 &&
      (process == group_.own() ||
        (source == group_.own() && plan_.sources[static_cast<std::size_t>(process)] != source));
  }

  /// To the processes whose boxes meet them.
  Leaves sortOut() const
  {
    Leaves all(count_);
    if (!topology_)
    {
      return all;
    }
    std::vector<int> receivers;
    for (int process = 0; process < group_.size(); ++process)
    {
      if (sendsTo(process))
      {
        receivers.push_back(process);
      }
    }
    struct Thread
    {
      Leaves leaves;
      std::vector<std::vector<int>> around; // by level: those of the receivers whose boxes meet the node
    };
    tbb::enumerable_thread_specific<Thread> threads([this] { return Thread{ Leaves(count_), {} }; });
    tbb::parallel_for(std::size_t(0), topology_->trees().size(), [&](std::size_t t) {
      const HyperTreeView& tree = topology_->trees()[t];
      auto& [leaves, around] = threads.local();
      const auto enter = [&, &around = around](const CellId& node) {
        const auto level = static_cast<std::size_t>(node.level);
        around.resize(std::max(around.size(), level + 1));
        const std::vector<int>& from = level > 0 ? around[level - 1] : receivers;
        around[level].clear();
        for (const int process : from)
        {
          if (boxOf(process).meets(node))
          {
            around[level].push_back(process);
          }
        }
      };
      forEachOwnLeaf(*topology_, tree, 0, { tree.root, 0 }, enter,
        [&, &leaves = leaves, &around = around](const CellId& place, vtkIdType vertex) {
          for (const int process : around[static_cast<std::size_t>(place.level)])
          {
            leaves[static_cast<std::size_t>(process)].push_back({ keyOf(place), tree.globalIndex(vertex) });
          }
        });
    });
    for (Thread& thread : threads)
    {
      for (std::size_t process = 0; process < count_; ++process)
      {
        all[process].insert(all[process].end(), thread.leaves[process].begin(), thread.leaves[process].end());
        thread.leaves[process] = {};
      }
    }
    return all;
  }

  CellBlock pack(const LargeVector<Leaf>& leaves) const
  {
    CellBlock block(leaves.size(), sizeof(Key), arrays_.arrays());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 4096), [&](const auto& range) {
      const int turned = topology_->trees().front().turned;
      for (std::size_t i = range.begin(); i != range.end(); ++i)
      {
        block.template keys<Key>()[i] = leaves[i].key;
        for (std::size_t a = 0; a < arrays_.arrays().size(); ++a)
        {
          arrays_.copyTuple(a, leaves[i].index, turned, block.tuples(a) + i * arrays_.arrays()[a].tupleBytes);
        }
      }
    });
    return block;
  }

  void receiveBox()
  {
    std::vector<Bytes> messages;
    group_.together([&] {
      messages.resize(count_);
      Leaves leaves = sortOut();
      for (std::size_t process = 0; process < count_; ++process)
      {
        if (!leaves[process].empty())
        {
          messages[process] = pack(leaves[process]).takeBytes();
          leaves[process] = {};
        }
      }
    });
    messages = group_.exchange(std::move(messages));
    group_.together([&] {
      for (std::size_t process = 0; process < count_; ++process)
      {
        if (!messages[process].empty())
        {
          // So that everywhere the same one of equal cells comes first.
          const auto source = static_cast<std::size_t>(plan_.sources[process]);
          blocks_[source] = CellBlock(std::move(messages[process]), sizeof(Key), arrays_.arrays());
        }
      }
      sortBox();
    });
  }

  std::vector<std::size_t> startsOf(std::size_t first) const
  {
    std::vector<std::size_t> starts{ first };
    for (const CellBlock& block : blocks_)
    {
      starts.push_back(starts.back() + block.size());
    }
    return starts;
  }

  /// Of all blocks, in no order.
  Cells listBlocks(std::size_t before) const
  {
    const std::vector<std::size_t> starts = startsOf(before);
    Cells cells(padding_, plan_.deepest, starts.back());
    for (std::size_t b = 0; b < blocks_.size(); ++b)
    {
      const Key* const keys = blocks_[b].size() > 0 ? blocks_[b].template keys<Key>() : nullptr;
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks_[b].size(), 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
        {
          cells.set(starts[b] + i, cellOf(keys[i]), CellNumber(b, static_cast<vtkIdType>(i)).number());
        }
      });
    }
    return cells;
  }

  void sortBox()
  {
    cells_.emplace(listBlocks(0));
    cells_->sort();
    keepFirstOfDuplicates(*cells_, [this](const CellNumber& a, const CellNumber& b, const CellId& place) {
      std::array<double, 3> low{};
      for (int axis = 0; axis < 3; ++axis)
      {
        low[axis] = roots_.worldPlane(axis, place.index[axis], place.level);
      }
      throw Error("hyper tree grids of processes " + std::to_string(a.block()) + " and " +
        std::to_string(b.block()) + ": cells of different levels overlap at " + textOf(low) +
        ", allowed is one at each place; others are to be marked as ghosts, hidden or masked");
    });
  }

  // 2. Those beyond the box.

  /// Whether leaves below say nothing about what is needed outside, which no search reaches from there (FieldSupport.cpp goes
  /// three widths of a node and two more). A parent's width, so that none of its children are told apart.
  bool isDeep(const CellId& cell) const noexcept
  {
    constexpr Coord reach = 5;
    CellId first = ancestor(cell, std::max(cell.level - 1, 0));
    CellId last = first;
    for (int a = 0; a < 3; ++a)
    {
      const Coord end = Coord(roots_.roots()[a]) << first.level;
      last.index[a] = std::min(first.index[a] + reach, end - 1);
      first.index[a] = std::max<Coord>(first.index[a] - reach, 0);
    }
    const LatticeBox& box = plan_.partition.box();
    return box.contains(first) && box.contains(last);
  }

  /// Adds a leaf's cell, unless the one before is of the same.
  void addDrawn(std::vector<LeafCell>& cells, const CellId& leaf) const
  {
    const CellId cell = drawn(leaf);
    if (cells.empty() || cells.back().cell.level != cell.level || cells.back().cell.index != cell.index)
    {
      cells.push_back({ cell, 0.f });
    }
  }

  std::vector<LeafCell> findBorder() const
  {
    std::vector<LeafCell> border;
    for (std::size_t i = 0; i < cells_->size(); ++i)
    {
      const CellId leaf = cells_->cell(i);
      if (!isDeep(drawn(leaf)))
      {
        addDrawn(border, leaf);
      }
    }
    return border;
  }

  /// Places that are not known yet; none: support_.needed is complete.
  std::vector<CellId> findUnknown(const std::vector<LeafCell>& border, const CellSet& known)
  {
    std::vector<LeafCell> cells = border;
    for (const Outside& outside : outside_)
    {
      addDrawn(cells, cellOf(outside.key));
    }
    support_ = findFieldSupport(*buildOctree(roots_, std::move(cells)).octree, plan_.partition.box(), known);
    std::vector<CellId> unknown;
    for (std::size_t i = 0; i < support_.unknown.size(); ++i)
    {
      unknown.push_back(drawn(support_.unknown[i]));
    }
    return unknown;
  }

  void findOutside()
  {
    std::vector<LeafCell> border;
    CellSet known(padding_);
    group_.together([&] { border = findBorder(); });
    for (bool isComplete = false;;)
    {
      std::vector<Bytes> messages;
      group_.together([&] {
        messages.resize(count_);
        if (!isComplete)
        {
          const CellSet places(padding_, findUnknown(border, known));
          isComplete = places.isEmpty();
          ask(places, known, messages);
        }
      });
      if (!group_.any(!isComplete))
      {
        break;
      }
      messages = group_.exchange(std::move(messages));
      group_.together([&] {
        for (int process = 0; process < group_.size(); ++process)
        {
          messages[static_cast<std::size_t>(process)] =
            answer(boxOf(process), messages[static_cast<std::size_t>(process)]);
        }
      });
      messages = group_.exchange(std::move(messages));
      group_.together([&] { addOutside(messages); });
    }
    group_.together([&] {
      std::erase_if(outside_,
        [this](const Outside& outside) { return !support_.needed.meets(drawn(cellOf(outside.key))); });
    });
  }

  /// The owners of the boxes that places meet.
  void ask(const CellSet& places, CellSet& known, std::vector<Bytes>& messages) const
  {
    std::vector<CellId> asked;
    for (std::size_t i = 0; i < places.size(); ++i)
    {
      asked.push_back(places[i]);
      for (int process = 0; process < group_.size(); ++process)
      {
        if (process != group_.own() && boxOf(process).meets(places[i]))
        {
          append(messages[static_cast<std::size_t>(process)], keyOf(places[i]));
        }
      }
    }
    known.add(asked);
  }

  static void append(Bytes& bytes, const Key& key)
  {
    const auto* const first = reinterpret_cast<const std::byte*>(&key);
    bytes.insert(bytes.end(), first, first + sizeof(Key));
  }
  template <class Visit>
  static void forEachKey(const Bytes& bytes, const Visit& visit)
  {
    for (std::size_t at = 0; at + sizeof(Key) <= bytes.size(); at += sizeof(Key))
    {
      Key key;
      std::memcpy(&key, bytes.data() + at, sizeof(Key));
      visit(key);
    }
  }

  /// The first of this process' cells that does not come before a place.
  std::size_t lowerBound(const Key& key) const
  {
    std::size_t first = 0;
    for (std::size_t last = cells_->size(); first < last;)
    {
      const std::size_t middle = first + (last - first) / 2;
      cells_->key(middle) < key ? first = middle + 1 : last = middle;
    }
    return first;
  }

  /// Its cells in and around places, but for those that the other's box meets.
  Bytes answer(const LatticeBox& other, const Bytes& places) const
  {
    Bytes found;
    forEachKey(places, [&](const Key& place) {
      const auto isNested = [&](std::size_t i) {
        const Key& key = cells_->key(i);
        return keys_.commonDepth(key, place) >= std::min(keys_.depth(key), keys_.depth(place));
      };
      // They stand beside each other, on both sides of the place.
      std::size_t first = lowerBound(place);
      std::size_t last = first;
      for (; first > 0 && isNested(first - 1); --first)
      {
      }
      for (; last < cells_->size() && isNested(last); ++last)
      {
      }
      for (std::size_t i = first; i < last; ++i)
      {
        if (!other.meets(cells_->cell(i)))
        {
          append(found, cells_->key(i));
        }
      }
    });
    return found;
  }

  void addOutside(const std::vector<Bytes>& messages)
  {
    for (int process = 0; process < group_.size(); ++process)
    {
      forEachKey(messages[static_cast<std::size_t>(process)], [&](const Key& key) {
        outside_.push_back({ key, process });
      });
    }
    std::ranges::sort(outside_);
    const auto [first, last] = std::ranges::unique(outside_, {}, &Outside::key);
    outside_.erase(first, last);
  }

  // 3. The grid.

  void receiveOutside()
  {
    std::vector<Bytes> messages;
    group_.together([&] {
      messages.resize(count_);
      for (const Outside& outside : outside_)
      {
        append(messages[static_cast<std::size_t>(outside.owner)], outside.key);
      }
      outside_ = {};
    });
    messages = group_.exchange(std::move(messages));
    group_.together([&] {
      for (Bytes& message : messages)
      {
        message = packHeld(message);
      }
    });
    messages = group_.exchange(std::move(messages));
    group_.together([&] {
      for (std::size_t process = 0; process < count_; ++process)
      {
        blocks_[count_ + process] = CellBlock(std::move(messages[process]), sizeof(Key), arrays_.arrays());
      }
    });
  }

  Bytes packHeld(const Bytes& asked) const
  {
    if (asked.empty())
    {
      return {};
    }
    CellBlock block(asked.size() / sizeof(Key), sizeof(Key), arrays_.arrays());
    std::size_t i = 0;
    forEachKey(asked, [&](const Key& key) {
      block.template keys<Key>()[i] = key;
      const CellNumber number(cells_->value(lowerBound(key)));
      for (std::size_t a = 0; a < arrays_.arrays().size(); ++a)
      {
        const std::size_t bytes = arrays_.arrays()[a].tupleBytes;
        std::memcpy(block.tuples(a) + i * bytes,
          blocks_[number.block()].tuples(a) + static_cast<std::size_t>(number.cell()) * bytes, bytes);
      }
      ++i;
    });
    return block.takeBytes();
  }

  vtkSmartPointer<vtkHyperTreeGrid> build()
  {
    cells_.reset();
    Cells cells = listBlocks(0);
    cells.sort();
    cells.removeDuplicates(); // of which the first is the one that all have
    BlockArrays arrays;
    std::vector<vtkSmartPointer<vtkCellData>> data;
    for (CellBlock& block : blocks_)
    {
      data.push_back(block.cellData(arrays_.arrays()));
      arrays.blocks.emplace_back(data.back(), static_cast<vtkIdType>(block.size()), "");
    }
    for (const SharedArray& array : arrays_.arrays())
    {
      arrays.arrays.push_back({ array.name, false });
    }
    auto grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
    grid->SetDepthLimiter(plan_.depthLimit);
    buildGrid(cells, plan_.planes, arrays, grid, [&](ParallelGridBuilder<Keys>& builder) {
      builder.addArray(std::make_unique<GhostFiller>(builder.nodeCount(), [this](const TreeLeaf& leaf) {
        const CellNumber number(leaf.number);
        const Key* const keys = blocks_[number.block()].template keys<Key>();
        return !plan_.partition.box().owns(cellOf(keys[number.cell()]));
      }));
    });
    setPartition(*grid, plan_.partition);
    return grid;
  }

  const ProcessGroup& group_;
  const ExchangePlan& plan_;
  const SharedArrays& arrays_;
  const HyperTreeGridTopology* topology_;
  RootGrid roots_;
  int padding_;
  Keys keys_;
  int coarsest_; // level of a cell that is drawn
  std::size_t count_;
  std::vector<CellBlock> blocks_; // by source, then by the owner of cells beyond the box
  std::optional<Cells> cells_;    // that meet the box, sorted
  FieldSupport support_;
  std::vector<Outside> outside_; // sorted
};

} // namespace

vtkSmartPointer<vtkHyperTreeGrid> exchangeCells(const ProcessGroup& group, const ExchangePlan& plan,
  const SharedArrays& arrays, const HyperTreeGridTopology* topology)
{
  return withKeys(RootGrid(plan.planes).paddingDepth() + plan.deepest,
    [&]<class Keys>() { return CellExchange<Keys>(group, plan, arrays, topology).run(); });
}

} // namespace treeamr
