// Which quadrants of a forest's file one of many processes reads: those in its box and those beyond that the field there
// depends on. Each finds its own in the file, by bisection; none asks another one or lists them all.
#pragma once

#include "Forest/P4estForestFile.h"
#include "Forest/TreeLattice.h"

#include "Partition/LatticeBox.h"

#include <cstdint>
#include <vector>

namespace treeamr
{

class ForestPiece
{
public:
  /// file, lattice: must live as long; of three dimensions. 0 <= piece < pieces. Throws Error as P4estForestFile where the
  /// quadrants that it looks at are not right.
  ForestPiece(const P4estForestFile& file, const TreeLattice& lattice, int piece, int pieces);

  /// Of all pieces: they fill the domain. The same for each that asks.
  const std::vector<LatticeBox>& boxes() const noexcept { return boxes_; }
  const LatticeBox& box() const noexcept { return boxes_[static_cast<std::size_t>(piece_)]; }
  /// Of the piece.
  std::uint64_t leafCount() const noexcept { return starts_.back(); }
  /// What it took to find them.
  struct Effort
  {
    std::uint64_t quadrantsRead = 0; // near the box's faces
    int rounds = 0;                  // of asking what the field depends on
  };
  const Effort& effort() const noexcept { return effort_; }
  /// The ranges of its leaves [begin, end), counted from 0, in the file.
  std::vector<LeafRange> ranges(std::uint64_t begin, std::uint64_t end) const;
  /// Of each tree: nodes of its leaves, with places that none is at; 0 without leaves.
  std::vector<std::uint64_t> nodeCounts() const;
  /// Whether a leaf is another piece's.
  bool isGhost(const TreeLeaf& leaf) const noexcept
  {
    return !box().owns(lattice_.cellOf(leaf.tree, leaf.index, leaf.level));
  }

private:
  struct Place;
  struct Listed;
  class Walk;

  std::vector<Place> splitTrees() const;
  void cutBoxes(int pieces);
  LatticeBox withBorder(int level) const;
  Listed findQuadrants(const std::vector<Place>& places) const;
  std::vector<LeafRange> readUnknown(const std::vector<CellId>& cells) const;
  template <class Visit>
  void readCells(const std::vector<LeafRange>& ranges, const Visit& visit) const;

  const P4estForestFile& file_;
  const TreeLattice& lattice_;
  RootGrid grid_;
  int piece_;
  std::vector<LatticeBox> boxes_;
  Effort effort_;
  std::vector<LeafRange> ranges_;     // ascending, apart from each other
  std::vector<std::uint64_t> starts_; // of the ranges' leaves among the piece's, and the end
};

} // namespace treeamr
