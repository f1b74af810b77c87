#include "Forest/P4estTreeLayout.h"

#include "Error.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

using Place = std::array<int, 3>;

/// Of a face (-x, +x, -y, ...), corners in Morton order.
int faceCorner(int face, int corner)
{
  const int axis = face / 2;
  const int low = axis == 0 ? 1 : 0; // the axes of the face
  const int high = axis == 2 ? 1 : 2;
  return (face % 2) << axis | (corner & 1) << low | (corner >> 1) << high;
}

/// The lattice's axis along an axis of the tree.
int latticeAxis(const TreeOrientation& orientation, int axis)
{
  return (orientation[std::size_t(1) << axis] ^ orientation[0]) >> 1; // of 1, 2 and 4
}

/// The lattice's face that a face of the tree is.
int latticeFace(const TreeOrientation& orientation, int face)
{
  const int axis = latticeAxis(orientation, face / 2);
  return 2 * axis + (orientation[faceCorner(face, 0)] >> axis & 1);
}

/// All turns; p4est knows no reflections. Of a plane those that leave the third axis as it is, and reflections, too.
std::vector<TreeOrientation> turns(int dimension)
{
  std::vector<TreeOrientation> turns;
  std::array<int, 3> axes{ 0, 1, 2 };
  do
  {
    for (int flips = 0; flips < 8; ++flips)
    {
      TreeOrientation orientation{};
      int sign = 1;
      for (int a = 0; a < 3; ++a)
      {
        for (int b = 0; b < a; ++b)
        {
          sign = axes[b] > axes[a] ? -sign : sign;
        }
        sign = flips >> a & 1 ? -sign : sign;
        for (int c = 0; c < 8; ++c)
        {
          orientation[c] |= static_cast<std::uint8_t>(((c ^ flips) >> a & 1) << axes[a]);
        }
      }
      if (dimension == 3 ? sign > 0 : axes[2] == 2 && (flips & 4) == 0)
      {
        turns.push_back(orientation);
      }
    }
  }
  while (std::ranges::next_permutation(axes).found);
  return turns;
}

class Layout
{
public:
  explicit Layout(const P4estForestFile& file)
    : file_(file)
    , turns_(turns(file.dimension()))
    , trees_(file.treeCount())
  {
    this->place(0, { 0, 0, 0 }, alongAxes);
    while (!rising_.empty() || !falling_.empty())
    {
      std::deque<Side>& sides = rising_.empty() ? falling_ : rising_;
      const Side side = sides.front();
      sides.pop_front();
      this->join(side);
    }
    for (std::size_t tree = 0; tree < trees_.size(); ++tree)
    {
      if (!trees_[tree].isPlaced)
      {
        throw Error(file_.path() + ": tree " + std::to_string(tree) +
          ": no vertices, and no face joins it with tree 0, allowed connected trees");
      }
    }
  }

  TreeLayout take()
  {
    TreeLayout layout;
    Place first;
    Place last;
    first.fill(std::numeric_limits<int>::max());
    last.fill(std::numeric_limits<int>::min());
    for (const Tree& tree : trees_)
    {
      for (int a = 0; a < 3; ++a)
      {
        first[a] = std::min(first[a], tree.place[a]);
        last[a] = std::max(last[a], tree.place[a]);
      }
    }
    for (const Tree& tree : trees_)
    {
      Place& place = layout.places.emplace_back(tree.place);
      for (int a = 0; a < 3; ++a)
      {
        place[a] -= first[a];
      }
      layout.orientations.push_back(tree.orientation);
    }
    for (int a = 0; a < 3; ++a)
    {
      layout.size[a] = last[a] - first[a] + 1;
    }
    return layout;
  }

private:
  struct Tree
  {
    bool isPlaced = false;
    Place place{};
    TreeOrientation orientation = alongAxes;
  };
  struct Side
  {
    std::int32_t tree;
    int face;
  };

  const P4estConnectivity::Neighbour& beyond(const Side& side) const
  {
    return file_.connectivity().neighbours[side.tree][side.face];
  }

  void place(std::int32_t tree, const Place& place, const TreeOrientation& orientation)
  {
    trees_[tree] = { true, place, orientation };
    for (int face = 0; face < 6; ++face)
    {
      const P4estConnectivity::Neighbour& neighbour = this->beyond({ tree, face });
      if (neighbour.tree != tree || neighbour.face != face) // no boundary
      {
        (latticeFace(orientation, face) % 2 == 1 ? rising_ : falling_).push_back({ tree, face });
      }
    }
  }

  void join(const Side& side)
  {
    const P4estConnectivity::Neighbour& neighbour = this->beyond(side);
    const P4estConnectivity::Neighbour& back = this->beyond({ neighbour.tree, neighbour.face });
    if (back.tree != side.tree || back.face != side.face || back.orientation != neighbour.orientation)
    {
      this->fail(side, neighbour, "which says otherwise of its face " + std::to_string(neighbour.face));
    }
    const Tree& tree = trees_[side.tree];
    const TreeOrientation orientation = this->orientationBeyond(side);
    if (!trees_[neighbour.tree].isPlaced)
    {
      const int face = latticeFace(tree.orientation, side.face);
      Place place = tree.place;
      place[face / 2] += face % 2 == 1 ? 1 : -1;
      this->place(neighbour.tree, place, orientation);
    }
    else if (trees_[neighbour.tree].orientation != orientation)
    {
      this->fail(side, neighbour, "turned against where other faces put it");
    }
  }

  [[noreturn]] void fail(
    const Side& side, const P4estConnectivity::Neighbour& neighbour, const std::string& how) const
  {
    throw Error(file_.path() + ": tree " + std::to_string(side.tree) + ", face " + std::to_string(side.face) +
      ": joined with tree " + std::to_string(neighbour.tree) + ", " + how +
      "; allowed are boxes of one lattice where the file has no vertices");
  }

  TreeOrientation orientationBeyond(const Side& side) const
  {
    const P4estConnectivity::Neighbour& neighbour = this->beyond(side);
    const TreeOrientation& own = trees_[side.tree].orientation;
    const int face = latticeFace(own, side.face);
    const auto fromCorners = std::ranges::find_if(
      turns_, [&](const TreeOrientation& turn) { return this->joinsCorners(side, turn, face); });
    if (fromCorners != turns_.end())
    {
      return *fromCorners;
    }
    const bool isLower = side.face <= neighbour.face;
    const int ownCorner = faceCorner(side.face, isLower ? 0 : neighbour.orientation);
    const int otherCorner = faceCorner(neighbour.face, isLower ? neighbour.orientation : 0);
    return *std::ranges::find_if(turns_, [&](const TreeOrientation& turn) {
      return latticeFace(turn, neighbour.face) == (face ^ 1) &&
        turn[otherCorner] == (own[ownCorner] ^ 1 << face / 2);
    });
  }

  /// Whether the neighbour, turned so, has all four corners of a face where this tree has them. It tells more than the face's
  /// orientation: deal.II's are wrong between cells that are turned against each other. face: of the lattice.
  bool joinsCorners(const Side& side, const TreeOrientation& turn, int face) const
  {
    const auto& corners = file_.connectivity().treeCorners;
    if (corners.empty())
    {
      return false;
    }
    const P4estConnectivity::Neighbour& neighbour = this->beyond(side);
    const TreeOrientation& own = trees_[side.tree].orientation;
    std::array<std::int32_t, 4> shared;
    for (int c = 0; c < 4; ++c)
    {
      const int ownCorner = faceCorner(side.face, c);
      const auto place = static_cast<std::uint8_t>(own[ownCorner] ^ 1 << face / 2);
      const auto otherCorner = std::ranges::find(turn, place) - turn.begin();
      shared[c] = corners[side.tree][ownCorner];
      if (shared[c] < 0 || corners[neighbour.tree][otherCorner] != shared[c])
      {
        return false;
      }
    }
    // In a periodic direction a face may have one corner twice.
    std::ranges::sort(shared);
    return latticeFace(turn, neighbour.face) == (face ^ 1) &&
      std::ranges::adjacent_find(shared) == shared.end();
  }

  const P4estForestFile& file_;
  const std::vector<TreeOrientation> turns_;
  std::vector<Tree> trees_;
  std::deque<Side> rising_; // of placed trees, along the lattice's axes
  std::deque<Side> falling_;
};

} // namespace

TreeLayout layOutTrees(const P4estForestFile& file)
{
  return Layout(file).take();
}

} // namespace treeamr
