// The octrees that axis-aligned boxes are the leaves of, from nothing but their coordinates.
//
// The largest boxes say how wide the roots are; all others must be halves, quarters ... of these, at multiples of their own
// width from one of the largest. Coordinates may be rounded: those of the whole set say the exact widths, as no single box
// can, and a corner fits a plane of the lattice when it is off by no more than
// - a 64th of the box's width, which no picture shows, and 1e-5 of the largest coordinate, what writers of text in six
//   digits leave, or
// - eight times what rounding to the coordinates' type may shift it by,
// and never by more than a quarter of the width.
// Boxes may be shrunk about their centres, all by the same factor: p8est_vtk leaves 0.95 of them.
#pragma once

#include "Octree/RootGrid.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace treeamr
{

/// (x, y, z), for messages.
std::string textOf(const std::array<double, 3>& values);

/// [axis][corner], corners in any order.
using CornerCoordinates = std::array<std::array<double, 8>, 3>;

struct AxisBox
{
  std::array<double, 3> low{};
  std::array<double, 3> high{};

  double width(int axis) const noexcept { return high[axis] - low[axis]; }
};

/// Of the corners' coordinates, NaN where one of them is.
AxisBox boxAround(const CornerCoordinates& corners) noexcept;
CornerCoordinates cornersOf(const AxisBox& box) noexcept;

/// Whether the corners are those of the box around them, as far as can be told without the others. rounding: of the
/// coordinates' type, relative.
bool isBox(const CornerCoordinates& corners, const AxisBox& around, double rounding) noexcept;

/// How large boxes are and where, by classes of nearly equal size. One for each thread, then put together.
class BoxSizes
{
public:
  struct Size
  {
    std::uint64_t bin;
    std::uint64_t count;
    std::array<double, 3> width; // the largest
    AxisBox bounds;              // of all boxes together
    AxisBox widest;              // one of those of the largest width along x
  };

  /// Of finite coordinates and widths above 0. count: of boxes of its size.
  void add(const AxisBox& box, std::uint64_t count = 1);
  void add(const BoxSizes& others);
  const std::vector<Size>& sizes() const noexcept { return sizes_; }
  /// Of sizes() that of the most boxes, which must not be empty.
  const Size& mostFrequent() const;
  /// By how much rounding may shift any of the coordinates, per axis. rounding: of their type, relative.
  std::array<double, 3> shiftBy(double rounding) const noexcept;

  static std::uint64_t binOf(const AxisBox& box) noexcept;

private:
  Size& find(std::uint64_t bin, const AxisBox& box);

  std::vector<Size> sizes_;
  std::size_t last_ = 0;
};

/// The distance between neighbours in a list of centres along one axis, of boxes of a width: the most frequent of the
/// distances above half of it. 0: there are no two places.
double distanceOfNeighbours(std::vector<double> centres, double width);

/// Whether a box is of the width of another, or a half, a quarter ... of it, and at a multiple of its own from that one, to a
/// 16th of its width and what the other's rounding makes up to over the distance. shift: by which rounding may shift a
/// coordinate. scale: by which both are shrunk.
bool fitsBeside(
  const AxisBox& other, const AxisBox& box, const std::array<double, 3>& shift, double scale) noexcept;

class BoxLattice
{
public:
  /// The deepest level of a box below its root.
  static constexpr int deepestLevel = 31;

  /// sizes: of one box or more. rounding: of the coordinates' type, relative. scale: by which the boxes are shrunk.
  /// Throws Error for a lattice of more roots along an axis than maxRoots.
  BoxLattice(const BoxSizes& sizes, double rounding, double scale = 1.);
  static constexpr std::int64_t maxRoots = std::int64_t(1) << 20;
  static constexpr std::int64_t manyTrees = std::int64_t(1) << 16;

  /// Nothing for corners of which one fits no plane.
  std::optional<CellId> place(const CornerCoordinates& corners) const noexcept;

  /// Of roots, which may be some times wider than the largest box: fewer and deeper trees take less memory and time. As long
  /// as there could be more than manyTrees, the last ones reach beyond the boxes where numbers are odd.
  const std::array<int, 3>& roots() const noexcept { return roots_; }
  /// Their planes. Those at the ends are the boxes' own coordinates where boxes reach there.
  const std::array<std::vector<double>, 3>& planes() const noexcept { return planes_; }
  /// Of the deepest boxes.
  int deepest() const noexcept { return deepest_; }
  /// The width of the largest boxes.
  std::array<double, 3> largestWidths() const noexcept;
  /// One of these, as it is.
  const AxisBox& widest() const noexcept { return widest_; }

private:
  void fitAxis(const BoxSizes& sizes, const std::vector<int>& levels, int axis);
  void joinRoots(std::uint64_t boxes);

  double rounding_;
  double scale_;
  AxisBox widest_;
  std::array<int, 3> roots_{};
  int deepest_ = 0;
  int joined_ = 0;                  // levels between the roots and the largest boxes
  std::array<double, 3> largest_{}; // magnitude of a coordinate
  std::array<double, 3> low_{};     // the first plane
  std::array<std::vector<double>, 3> planes_;
  std::array<std::array<double, deepestLevel + 1>, 3> widths_{}; // of a cell, by axis and level
  std::array<std::array<double, deepestLevel + 1>, 3> slack_{};  // how far a coordinate may be off
};

} // namespace treeamr
