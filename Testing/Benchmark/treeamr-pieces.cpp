// What processes hold and read of a forest's file, and how its cells are shared, for any number of them. One after the other:
// none asks another.
//
// treeamr-pieces FOREST.p8est [RANKS...]
// By default 1 2 3 4 8 16. Of more than 16 ranks the boxes' cells are counted for all, the rest for 16 spread among them.
#include "Forest/ForestPiece.h"
#include "Forest/P4estForestFile.h"
#include "Forest/P4estTreeLattice.h"
#include "Meter.h"
#include "Partition/BoxCuts.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

namespace
{

using namespace treeamr;

/// By calls of this process.
double bytesRead()
{
  std::ifstream io("/proc/self/io");
  std::string key;
  double bytes = 0.;
  io >> key >> bytes; // rchar:
  return bytes;
}

class Mean
{
public:
  void add(double number)
  {
    sum_ += number;
    most_ = std::max(most_, number);
    ++count_;
  }
  double mean() const noexcept { return sum_ / count_; }
  double most() const noexcept { return most_; }

private:
  double sum_ = 0.;
  double most_ = 0.;
  int count_ = 0;
};

class Forest
{
public:
  explicit Forest(const char* path)
    : file_(path)
    , lattice_(p4estTreeLattice(file_))
  {
  }

  double cells() const noexcept { return static_cast<double>(file_.quadrantCount()); }
  void measure(int ranks) const;

private:
  double countGhosts(const ForestPiece& piece) const;
  /// Of the boxes, the most; what lies in two counts in parts.
  double mostCells(const std::vector<LatticeBox>& boxes, int ranks) const;

  P4estForestFile file_;
  TreeLattice lattice_;
};

double Forest::countGhosts(const ForestPiece& piece) const
{
  double ghosts = 0.;
  LeafBlock block;
  const std::uint64_t step = file_.blockQuadrants();
  for (std::uint64_t begin = 0; begin < piece.leafCount(); begin += step)
  {
    file_.readQuadrants(piece.ranges(begin, std::min(begin + step, piece.leafCount())), block);
    ghosts += static_cast<double>(
      std::ranges::count_if(block.leaves, [&](const TreeLeaf& leaf) { return piece.isGhost(leaf); }));
  }
  return ghosts;
}

double Forest::mostCells(const std::vector<LatticeBox>& boxes, int ranks) const
{
  const std::array<int, 3> roots = RootGrid(lattice_.planes()).roots();
  CellHistogram histogram(roots, CellHistogram::levelFor(roots, ranks, P4estForestFile::maxLevel));
  file_.visitQuadrants([&](const TreeLeaf& leaf) {
    histogram.add(lattice_.cellOf(leaf.tree, leaf.index, leaf.level));
  });
  double most = 0.;
  for (const LatticeBox& box : boxes)
  {
    double cells = 0.;
    std::array<Coord, 3> at;
    for (at[2] = box.begin[2]; at[2] < box.end[2]; ++at[2])
    {
      for (at[1] = box.begin[1]; at[1] < box.end[1]; ++at[1])
      {
        for (at[0] = box.begin[0]; at[0] < box.end[0]; ++at[0])
        {
          const std::array<Coord, 3>& size = histogram.size();
          cells += histogram.counts()[at[0] + size[0] * (at[1] + size[1] * at[2])];
        }
      }
    }
    most = std::max(most, cells);
  }
  return most;
}

void Forest::measure(int ranks) const
{
  constexpr int mostMeasured = 16;
  const int measured = std::min(ranks, mostMeasured);
  Mean own;
  Mean ghosts;
  Mean looked;
  Mean rounds;
  Mean bytes;
  Mean cpu;
  double most = 0.;
  for (int i = 0; i < measured; ++i)
  {
    const double before = bytesRead();
    const bench::Cost start = bench::spent();
    const ForestPiece piece(file_, lattice_, static_cast<int>(std::int64_t(i) * ranks / measured), ranks);
    cpu.add(bench::spent().cpu - start.cpu);
    bytes.add(bytesRead() - before);
    looked.add(static_cast<double>(piece.effort().quadrantsRead));
    rounds.add(piece.effort().rounds);
    const double beyond = countGhosts(piece);
    ghosts.add(beyond);
    own.add(static_cast<double>(piece.leafCount()) - beyond);
    if (i == 0)
    {
      most = mostCells(piece.boxes(), ranks);
    }
  }
  std::printf("| %d | %.0f | %.0f | %.0f | %.0f | %.1f %% | %.0f | %.0f | %.1f | %.2f |\n", ranks,
    cells() / ranks, most, ghosts.mean(), ghosts.most(), 100. * ghosts.mean() / own.mean(), looked.mean(),
    rounds.most(), bytes.mean() / 0x1p20, cpu.mean());
  std::fflush(stdout);
}

} // namespace

int main(int argc, char* argv[])
{
  std::vector<int> counts;
  for (int i = 2; i < argc; ++i)
  {
    const std::string_view text = argv[i];
    int count = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), count);
    counts.push_back(code == std::errc() && end == text.data() + text.size() ? count : 0);
  }
  if (argc < 2 || std::ranges::any_of(counts, [](int count) { return count < 1; }))
  {
    std::cerr << "usage: treeamr-pieces FOREST.p8est [RANKS...]\nby default 1 2 3 4 8 16; RANKS 1 or more\n";
    return 2;
  }
  if (counts.empty())
  {
    counts = { 1, 2, 3, 4, 8, 16 };
  }
  try
  {
    const Forest forest(argv[1]);
    std::printf("%.0f cells\n\n"
                "| ranks | cells of each | most in a box | ghosts, mean | most | of its own | read to find them | "
                "rounds | MiB read | CPU s |\n|---|---|---|---|---|---|---|---|---|---|\n",
      forest.cells());
    for (const int count : counts)
    {
      forest.measure(count);
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "treeamr-pieces: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
