// Three passes over the cells: how large they are and where, their places on the lattice that follows from it, and, sorted
// by these, their arrays.
#include "HexahedronGrid.h"

#include "Error.h"
#include "GridOfCells.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <string>

namespace treeamr
{

namespace
{

/// Cells of a block, for a thread, and how many cells are taken of chunks before.
struct Chunk
{
  std::size_t block;
  vtkIdType begin;
  vtkIdType end;
  std::size_t before = 0;
};

/// The least number that threads have found.
class FirstCell
{
public:
  void add(const CellNumber& cell) noexcept
  {
    std::uint64_t now = first_.load(std::memory_order_relaxed);
    while (cell.number() < now && !first_.compare_exchange_weak(now, cell.number()))
    {
    }
  }
  std::optional<CellNumber> found() const noexcept
  {
    return first_ == none ? std::nullopt : std::optional(CellNumber(first_));
  }

private:
  static constexpr std::uint64_t none = ~std::uint64_t(0);

  std::atomic<std::uint64_t> first_{ none };
};

class HexahedronConverter
{
public:
  explicit HexahedronConverter(const std::vector<HexahedronBlock>& blocks)
    : blocks_(blocks)
    , rounding_(std::ranges::any_of(blocks, &HexahedronBlock::hasFloats) ? 0x1p-24 : 0x1p-53)
  {
    constexpr vtkIdType length = 1 << 14;
    for (std::size_t b = 0; b < blocks.size(); ++b)
    {
      for (vtkIdType begin = 0; begin < blocks[b].cellCount(); begin += length)
      {
        chunks_.push_back({ b, begin, std::min(begin + length, blocks[b].cellCount()) });
      }
    }
    measure();
  }

  /// Of cells that are not left out.
  std::size_t cellCount() const noexcept { return cellCount_; }

  /// Of the cells as they are.
  BoxLattice findLattice() const
  {
    if (sizes_.sizes().empty())
    {
      fail(*firstNoBox_.found(), {});
    }
    return BoxLattice(sizes_, rounding_);
  }
  /// Of shrunk ones, which some tell as well as all, unless the neighbours of these are missing among them. Nothing when they
  /// are not shrunk.
  std::optional<BoxLattice> findLatticeOfShrunk() const
  {
    constexpr std::size_t some = 1 << 16;
    const double scale = findScale(some);
    return scale < 1. ? std::optional(BoxLattice(sizes_, rounding_, scale)) : std::nullopt;
  }
  /// When cells fit neither: of all but those that are wrong. Throws Error unless there are none.
  BoxLattice findLatticeOfMost() const
  {
    const double scale = findScale(cellCount_);
    BoxLattice lattice(sizesThatFit(scale), rounding_, scale);
    if (const auto misfit = placeCells(lattice, [](std::size_t, const CellId&, const CellNumber&) {}))
    {
      fail(*misfit, lattice);
    }
    return lattice;
  }

  /// Nothing when cells do not fit.
  template <class Keys>
  std::optional<SortedCells<Keys, std::uint64_t>> sortCells(const BoxLattice& lattice) const
  {
    SortedCells<Keys, std::uint64_t> cells(paddingOf(lattice), lattice.deepest(), cellCount_);
    const auto misfit =
      placeCells(lattice, [&](std::size_t at, const CellId& place, const CellNumber& number) {
        cells.set(at, place, number.number());
      });
    if (misfit)
    {
      return std::nullopt;
    }
    cells.sort();
    keepFirstOfDuplicates(
      cells, [this](const CellNumber& first, const CellNumber& second, const CellId& /*place*/) {
        throw Error("cells overlap: " + describe(first) + ", and " + describe(second));
      });
    return cells;
  }

private:
  template <class Body>
  void forEachChunk(const Body& body) const
  {
    tbb::parallel_for(std::size_t(0), chunks_.size(), [&](std::size_t c) { body(chunks_[c]); });
  }
  template <class Body>
  void forEachCell(const Chunk& chunk, const Body& body) const
  {
    for (vtkIdType cell = chunk.begin; cell < chunk.end; ++cell)
    {
      if (!blocks_[chunk.block].isLeftOut(cell))
      {
        body(CellNumber(chunk.block, cell));
      }
    }
  }

  void measure()
  {
    tbb::enumerable_thread_specific<BoxSizes> sizes;
    tbb::parallel_for(std::size_t(0), chunks_.size(), [&](std::size_t c) {
      BoxSizes& mine = sizes.local();
      std::size_t count = 0;
      forEachCell(chunks_[c], [&](const CellNumber& number) {
        ++count;
        if (const std::optional<AxisBox> box = boxOf(number))
        {
          mine.add(*box);
        }
        else
        {
          firstNoBox_.add(number);
        }
      });
      chunks_[c].before = count;
    });
    for (Chunk& chunk : chunks_)
    {
      const std::size_t count = chunk.before;
      chunk.before = cellCount_;
      cellCount_ += count;
    }
    for (const BoxSizes& part : sizes)
    {
      sizes_.add(part);
    }
  }

  /// Calls set(i, place, number) for the i-th of the cells that are not left out. Returns the first that does not fit.
  template <class Set>
  std::optional<CellNumber> placeCells(const BoxLattice& lattice, const Set& set) const
  {
    FirstCell misfit;
    forEachChunk([&](const Chunk& chunk) {
      std::size_t at = chunk.before;
      bool fits = true;
      forEachCell(chunk, [&](const CellNumber& number) {
        if (!fits)
        {
          return; // the first is known
        }
        const HexahedronBlock& block = blocks_[number.block()];
        const std::optional<CellId> place =
          block.hasCorners(number.cell()) ? lattice.place(block.corners(number.cell())) : std::nullopt;
        fits = place.has_value();
        fits ? set(at++, *place, number) : misfit.add(number);
      });
    });
    return misfit.found();
  }

  /// By which the boxes are shrunk, for all axes; 1: not at all, or not alike. By so many boxes, in runs of those that follow
  /// each other, as neighbours often do.
  double findScale(std::size_t wanted) const
  {
    constexpr vtkIdType run = 64;
    const auto step = static_cast<vtkIdType>((cellCount_ + wanted - 1) / wanted);
    const BoxSizes::Size& size = sizes_.mostFrequent();
    double least = 1.;
    double most = 0.;
    for (int a = 0; a < 3; ++a)
    {
      tbb::enumerable_thread_specific<std::vector<double>> centres;
      forEachChunk([&](const Chunk& chunk) {
        std::vector<double>& mine = centres.local();
        forEachCell(chunk, [&](const CellNumber& number) {
          const bool isChosen = number.cell() / run % step == 0;
          const std::optional<AxisBox> box = isChosen ? boxOf(number) : std::nullopt;
          if (box && BoxSizes::binOf(*box) == size.bin)
          {
            mine.push_back(box->low[a] + box->width(a) / 2.);
          }
        });
      });
      std::vector<double> all;
      for (const std::vector<double>& part : centres)
      {
        all.insert(all.end(), part.begin(), part.end());
      }
      if (const double distance = distanceOfNeighbours(std::move(all), size.width[a]); distance > 0.)
      {
        least = std::min(least, size.width[a] / distance);
        most = std::max(most, size.width[a] / distance);
      }
    }
    constexpr double alike = 1e-2;
    constexpr double shrunk = 1. - 1e-3;
    return most > 0. && most < shrunk && most - least < alike ? (least + most) / 2. : 1.;
  }

  /// Without the boxes that do not fit where most others do, so that these are named and not those that are right.
  BoxSizes sizesThatFit(double scale) const
  {
    const std::vector<AxisBox> sample = sampleBoxes();
    const std::array<double, 3> shift = sizes_.shiftBy(rounding_);
    AxisBox best;
    std::ptrdiff_t most = -1;
    constexpr std::size_t tries = 64;
    const auto consider = [&](const AxisBox& box) {
      const auto count = std::ranges::count_if(
        sample, [&](const AxisBox& other) { return fitsBeside(box, other, shift, scale); });
      if (count > most || (count == most && box.width(0) > best.width(0)))
      {
        most = count;
        best = box;
      }
    };
    for (const BoxSizes::Size& size : sizes_.sizes())
    {
      consider(size.widest);
    }
    for (std::size_t i = 0; i < sample.size(); i += sample.size() / tries + 1)
    {
      consider(sample[i]);
    }

    tbb::enumerable_thread_specific<BoxSizes> sizes;
    forEachChunk([&](const Chunk& chunk) {
      BoxSizes& mine = sizes.local();
      forEachCell(chunk, [&](const CellNumber& number) {
        const std::optional<AxisBox> box = boxOf(number);
        if (box && fitsBeside(best, *box, shift, scale))
        {
          mine.add(*box);
        }
      });
    });
    BoxSizes all;
    for (const BoxSizes& part : sizes)
    {
      all.add(part);
    }
    return all;
  }

  /// Some thousands, from everywhere in the order of the cells.
  std::vector<AxisBox> sampleBoxes() const
  {
    constexpr std::size_t wanted = 4096;
    const std::size_t step = cellCount_ / wanted + 1;
    std::vector<AxisBox> sample;
    std::size_t count = 0;
    for (const Chunk& chunk : chunks_)
    {
      forEachCell(chunk, [&](const CellNumber& number) {
        const std::optional<AxisBox> box = count++ % step == 0 ? boxOf(number) : std::nullopt;
        if (box)
        {
          sample.push_back(*box);
        }
      });
    }
    return sample;
  }

  std::optional<AxisBox> boxOf(const CellNumber& number) const
  {
    const HexahedronBlock& block = blocks_[number.block()];
    if (block.hasCorners(number.cell()))
    {
      const CornerCoordinates corners = block.corners(number.cell());
      if (const AxisBox box = boxAround(corners); isBox(corners, box, rounding_))
      {
        return box;
      }
    }
    return std::nullopt;
  }

  std::string describe(const CellNumber& number) const
  {
    return blocks_[number.block()].describe(number.cell());
  }

  [[noreturn]] void fail(const CellNumber& number, const std::optional<BoxLattice>& lattice) const
  {
    if (lattice && boxOf(number))
    {
      throw Error(describe(number) + ", fits no place of the lattice of the largest cells, which are " +
        textOf(lattice->largestWidths()) + " wide like that from " + textOf(lattice->widest().low) + " to " +
        textOf(lattice->widest().high) +
        "; allowed are cells of these widths, halves, quarters ... of all three, that begin at multiples of "
        "their own widths from such a cell");
    }
    throw Error(describe(number) +
      "; allowed are hexahedra and voxels that are boxes along the axes, in three dimensions, of finite "
      "corners");
  }

  const std::vector<HexahedronBlock>& blocks_;
  double rounding_;
  std::vector<Chunk> chunks_;
  std::size_t cellCount_ = 0;
  BoxSizes sizes_;
  FirstCell firstNoBox_;
};

} // namespace

void makeGrid(const std::vector<HexahedronBlock>& blocks, const BlockArrays& arrays, vtkHyperTreeGrid* grid)
{
  const HexahedronConverter converter(blocks);
  if (converter.cellCount() == 0)
  {
    return;
  }
  const auto buildOn = [&](const BoxLattice& lattice) { // false when cells do not fit
    return withKeys(paddingOf(lattice) + lattice.deepest(), [&]<class Keys>() {
      const auto cells = converter.sortCells<Keys>(lattice);
      if (cells)
      {
        buildGrid(*cells, lattice.planes(), arrays, grid);
      }
      return cells.has_value();
    });
  };
  if (buildOn(converter.findLattice()))
  {
    return;
  }
  const std::optional<BoxLattice> shrunk = converter.findLatticeOfShrunk();
  if (!shrunk || !buildOn(*shrunk))
  {
    buildOn(converter.findLatticeOfMost());
  }
}

} // namespace treeamr
