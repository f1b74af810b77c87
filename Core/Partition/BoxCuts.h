// A domain cut into boxes that hold about as many cells each: a kd-tree, so that from any eye one box after the
// other can be drawn, which pieces of a space-filling curve cannot.
#pragma once

#include "Partition/LatticeBox.h"

#include <vector>

namespace treeamr
{

/// How many cells lie in each cell of the lattice of a level; parts of coarser ones count as parts. Below level 0 places are
/// of 2, 4 ... roots along each axis.
class CellHistogram
{
public:
  /// Of a lattice on which `parts` boxes can be cut well. deepestLevel: of the cells.
  static int levelFor(const std::array<int, 3>& roots, int parts, int deepestLevel) noexcept;

  CellHistogram(const std::array<int, 3>& roots, int level);

  int level() const noexcept { return level_; }
  const std::array<int, 3>& roots() const noexcept { return roots_; }
  const std::array<Coord, 3>& size() const noexcept { return size_; }
  /// At x + size[0] (y + size[1] z); what several processes have counted may be added up.
  std::vector<double>& counts() noexcept { return counts_; }
  const std::vector<double>& counts() const noexcept { return counts_; }
  /// count: of cells in that one.
  void add(const CellId& cell, double count = 1.) noexcept;

private:
  int level_;
  std::array<int, 3> roots_;
  std::array<Coord, 3> size_;
  std::vector<double> counts_;
};

/// Disjoint boxes that fill the domain, one for each part, in depth-first order of the cuts. Where there are fewer places
/// than parts, some are empty. The same for the same histogram, whoever asks.
std::vector<LatticeBox> cutBoxes(const CellHistogram& histogram, int parts);

} // namespace treeamr
