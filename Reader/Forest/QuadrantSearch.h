// Where the quadrants of a node are in a p4est forest file, found without reading those before them.
#pragma once

#include "Forest/P4estInputFile.h"
#include "Forest/TreeLeaf.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

class P4estForestFile;

/// Finds by bisection which quadrants lie where, in the order of their trees. For one thread: it keeps the pages it has read.
class QuadrantSearch
{
public:
  /// file: must live as long. Throws Error when it cannot be opened again.
  explicit QuadrantSearch(const P4estForestFile& file);

  /// range: of all quadrants in a node of a level of some tree, more than one. Those in one of its children. Throws Error when
  /// they cannot be read; of a file whose quadrants are not in order it gives any.
  LeafRange child(const LeafRange& range, int level, int octant);

private:
  static constexpr std::uint64_t pageQuadrants = 128;
  static constexpr std::size_t pageCount = 64;
  struct Page
  {
    std::uint64_t number = ~std::uint64_t(0);
    std::array<std::array<std::int32_t, 3>, pageQuadrants> anchors;
  };

  int childOf(std::uint64_t quadrant, int level);

  const P4estForestFile& file_;
  P4estInputFile input_;
  std::vector<Page> pages_; // by number modulo their count
};

} // namespace treeamr
