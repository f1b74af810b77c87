#include "Contour/BlockContour.h"

#include "Octree/Coverage.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeamr
{

namespace
{

constexpr std::array<int, 3> entryStride{ 1, 3, 9 }; // of a neighbourhood

constexpr int entryOfFace(int face)
{
  return 13 + (face & 1 ? entryStride[face >> 1] : -entryStride[face >> 1]);
}

} // namespace

OctantPlanes octantPlanes(const RootGrid& grid, const std::array<Coord, 3>& index, int depth) noexcept
{
  const int level = depth + 2 - grid.paddingDepth(); // of the octants
  OctantPlanes planes;
  for (int a = 0; a < 3; ++a)
  {
    const Coord end = Coord(grid.roots()[a]) << level;
    for (int i = 0; i < 7; ++i)
    {
      planes[a][i] = grid.worldPlane(a, std::clamp<Coord>(4 * index[a] + i - 1, 0, end), level);
    }
  }
  return planes;
}

BlockContour::BlockContour(const Field& field, double isovalue, const std::optional<LatticeBox>& box)
  : octree_(field.octree())
  , field_(field)
  , isovalue_(isovalue)
  , box_(box)
  , noneMissing_(!box && hasAllCells(octree_))
  , wholeLeaves_(field.corners() != nullptr)
  , finestDepth_(octree_.grid().paddingDepth() + octree_.leafLevels() + 1)
  , evaluator_(field)
{
}

void BlockContour::extract(TreePath& path, ContourPart& part)
{
  evaluator_.compute(BlockPath(path), BlockCells::Leaves, block_);
  if (!(block_.range.min < isovalue_ && isovalue_ <= block_.range.max))
  {
    return;
  }
  markInside();
  const Octree::Children children = octree_.children(path.node().index());
  started_ = false;
  for (unsigned rest = children.leaf; rest != 0; rest &= rest - 1)
  {
    const int octant = std::countr_zero(rest);
    if (crossesLeaf(octant))
    {
      if (!started_)
      {
        start(path.index(), path.depth(), children.allLeaves(), part);
        if (!wholeLeaves_)
        {
          dualCells_.find(path, field_);
        }
      }
      extractLeaf(path, octant, part);
    }
  }
  if (!started_)
  {
    return;
  }
  for (int corner = 0; corner < 27 && !wholeLeaves_; ++corner)
  {
    const Place place{ corner % 3, corner / 3 % 3, corner / 9 };
    if (dualCells_.has(place))
    {
      extractDual(place, part);
    }
  }
  if (static_cast<std::int64_t>(part.points.size()) == part.blocks.back().firstPoint)
  {
    part.blocks.pop_back();
  }
}

void BlockContour::extractOnlyLeaf(ContourPart& part)
{
  evaluator_.compute(BlockPath(), BlockCells::Leaves, block_);
  start({}, -1, true, part);
  extractWhole({ octree_.isGhost(0), 0, 0, 0, 0, {} }, 0, part);
}

void BlockContour::markInside() noexcept
{
  for (int row = 0; row < 25; ++row)
  {
    unsigned mask = 0;
    for (int x = 0; x < 5; ++x)
    {
      mask |= static_cast<unsigned>(block_.values[5 * row + x] >= isovalue_) << x;
    }
    inside_[row] = static_cast<std::uint8_t>(mask);
  }
}

bool BlockContour::crossesLeaf(int octant) const noexcept
{
  const int x = 2 * (octant & 1);
  const int row = 2 * (octant >> 1 & 1) + 10 * (octant >> 2);
  unsigned any = 0;
  unsigned all = 7;
  for (int i = 0; i < 9; ++i)
  {
    const unsigned bits = inside_[row + i % 3 + 5 * (i / 3)] >> x;
    any |= bits;
    all &= bits;
  }
  return (any & 7) != 0 && (all & 7) != 7;
}

void BlockContour::start(const std::array<Coord, 3>& index, int depth, bool alone, ContourPart& part)
{
  started_ = true;
  pointOfEdge_.fill(-1);
  pointOfWideEdge_.fill(-1);
  alone_ = alone;
  depth_ = depth + 2; // of the octants
  plane_ = octantPlanes(octree_.grid(), index, depth);
  for (int a = 0; a < 3; ++a)
  {
    base_[a] = 4 * index[a];
  }
  part.blocks.push_back({ index, depth, static_cast<std::int64_t>(part.points.size()) });
}

void BlockContour::extractLeaf(TreePath& path, int octant, ContourPart& part)
{
  path.descend(octant);
  const int depth = path.depth();
  Leaf leaf{ octree_.isGhost(path.node().index()), 0, 0, 0, 0, {} };
  const Neighbourhood& around = path.around(depth);
  for (int e = 0; e < 27; ++e)
  {
    const NodeRef node = around[e];
    leaf.inner |= static_cast<std::uint32_t>(node.isInner()) << e;
    if (node.isLeaf() && node.depth() < depth)
    {
      leaf.coarse |= 1u << e;
      leaf.ghosts |= static_cast<std::uint32_t>(octree_.isGhost(node.index())) << e;
      leaf.up[e] = static_cast<std::uint8_t>(depth - node.depth());
    }
    else
    {
      leaf.same |= static_cast<std::uint32_t>(node.isLeaf()) << e;
    }
  }
  path.ascend();
  if (wholeLeaves_)
  {
    extractWhole(leaf, octant, part);
    return;
  }
  for (int o = 0; o < 8; ++o)
  {
    Place low;
    Place corner; // of the leaf
    for (int a = 0; a < 3; ++a)
    {
      corner[a] = sideOf(octant, a) + sideOf(o, a);
      low[a] = 2 * sideOf(octant, a) + sideOf(o, a);
    }
    const std::uint8_t* row = inside_.data() + low[1] + 5 * low[2];
    const auto pair = [&](int i) { return static_cast<unsigned>(row[i] >> low[0] & 3); };
    const unsigned inside = pair(0) | pair(1) << 2 | pair(5) << 4 | pair(6) << 6;
    if (inside != 0 && inside != 0xff && !dualCells_.has(corner))
    {
      extractOctant(leaf, low, inside, part);
    }
  }
}

void BlockContour::extractOctant(const Leaf& leaf, const Place& low, unsigned inside, ContourPart& part)
{
  const int base = block::vertexIndex(low[0], low[1], low[2]);
  for (int c = 0; c < 8; ++c)
  {
    values_[c] = block_.values[base + cornerOffset(c, block::vertexStride)] - isovalue_;
  }
  const Piece piece{ low, 1, &leaf, inside };
  unsigned finer = 0; // masks of faces
  unsigned coarser = 0;
  std::array<PieceKey, 6> beyond;
  for (int f = 0; f < 6; ++f)
  {
    const int axis = f >> 1;
    const unsigned bit = 1u << f;
    if ((low[axis] & 1) == (f & 1)) // on the leaf's boundary
    {
      const std::uint32_t entry = 1u << entryOfFace(f);
      finer |= (leaf.inner & entry) != 0 ? bit : 0;
      if ((leaf.coarse & ~leaf.ghosts & entry) != 0)
      {
        coarser |= bit;
        beyond[f] = neighbour(piece, f);
        const int up = leaf.up[entryOfFace(f)];
        beyond[f].depth -= up;
        for (Coord& i : beyond[f].index)
        {
          i >>= up;
        }
      }
      continue;
    }
    Place corner; // which the leaf's octant beyond the face touches
    for (int a = 0; a < 3; ++a)
    {
      corner[a] = (low[a] + (a != axis ? 0 : f & 1 ? 1 : -1) + 1) >> 1;
    }
    if (dualCells_.has(corner))
    {
      coarser |= bit;
      beyond[f] = keyOf({ 2 * corner[0] - 1, 2 * corner[1] - 1, 2 * corner[2] - 1 }, 2);
    }
  }
  for (int f = 0; f < 6; ++f)
  {
    if (coarser >> f & 1)
    {
      handOver(piece, f, beyond[f], faceSegments(f, inside, values_), part);
    }
  }
  if (!leaf.ghost)
  {
    extractPiece(piece, finer, part);
  }
}

/// A leaf that is trilinear as a whole.
void BlockContour::extractWhole(const Leaf& leaf, int octant, ContourPart& part)
{
  Piece piece{ { 2 * sideOf(octant, 0), 2 * sideOf(octant, 1), 2 * sideOf(octant, 2) }, 2, &leaf, 0 };
  const int base = block::vertexIndex(piece.low[0], piece.low[1], piece.low[2]);
  for (int c = 0; c < 8; ++c)
  {
    values_[c] = block_.values[base + 2 * cornerOffset(c, block::vertexStride)] - isovalue_;
  }
  piece.inside = insideCorners(values_);
  if (piece.inside == 0 || piece.inside == 0xff)
  {
    return;
  }
  unsigned finer = 0; // mask of faces
  for (int f = 0; f < 6; ++f)
  {
    const std::uint32_t entry = 1u << entryOfFace(f);
    finer |= static_cast<unsigned>((leaf.inner & entry) != 0) << f;
    if ((leaf.coarse & ~leaf.ghosts & entry) != 0)
    {
      const int up = leaf.up[entryOfFace(f)];
      PieceKey beyond = keyOf(piece.low, 2);
      beyond.index[f >> 1] += f & 1 ? 2 : -2;
      beyond.depth -= up;
      for (Coord& i : beyond.index)
      {
        i = 2 * (i >> (up + 1));
      }
      handOver(piece, f, beyond, faceSegments(f, piece.inside, values_), part);
    }
  }
  if (!leaf.ghost)
  {
    extractPiece(piece, finer, part);
  }
}

void BlockContour::extractDual(const Place& corner, ContourPart& part)
{
  const std::array<float, 8> centres = dualCells_.values(corner);
  for (int c = 0; c < 8; ++c)
  {
    values_[c] = centres[c] - isovalue_;
  }
  Piece piece{ { 2 * corner[0] - 1, 2 * corner[1] - 1, 2 * corner[2] - 1 }, 2, nullptr,
    insideCorners(values_) };
  if (piece.inside == 0 || piece.inside == 0xff || !ownsDualCell(corner, centres, isovalue_))
  {
    return;
  }
  unsigned finer = 0;
  for (int f = 0; f < 6; ++f)
  {
    Place beside = corner;
    beside[f >> 1] += f & 1 ? 1 : -1;
    finer |= static_cast<unsigned>(!dualCells_.has(beside)) << f;
  }
  extractPiece(piece, finer, part);
}

void BlockContour::extractPiece(const Piece& piece, unsigned finer, ContourPart& part)
{
  const PieceKey key = keyOf(piece.low, piece.width);
  if (finer != 0)
  {
    part.lines.push_back({ key, static_cast<std::int64_t>(part.values.size()), TransitionLine::none,
      TransitionLine::valuesFace });
    part.values.push_back(values_);
  }
  std::array<std::int8_t, 12> next;
  next.fill(-1);
  for (int f = 0; f < 6; ++f)
  {
    if (finer >> f & 1)
    {
      if (!isComplete(key))
      {
        askFiner(piece, f, key, part);
      }
      continue;
    }
    const FaceSegments segments = faceSegments(f, piece.inside, values_);
    for (int i = 0; i < segments.count; ++i)
    {
      next[segments.from[i]] = static_cast<std::int8_t>(segments.to[i]);
      if (finer != 0)
      {
        part.lines.push_back({ key, pointOn(piece, segments.from[i], part),
          pointOn(piece, segments.to[i], part), TransitionLine::ownFace });
      }
    }
  }
  if (finer != 0)
  {
    return;
  }
  if (!box_ || owns(*box_, key, octree_.grid().paddingDepth()))
  {
    fillLoops(piece, next, part);
    return;
  }
  // Where an edge is crossed the largest piece around says, whoever owns it.
  for (int edge = 0; edge < 12; ++edge)
  {
    if (next[edge] >= 0)
    {
      pointOn(piece, edge, part);
    }
  }
}

/// The lines of a face to the piece beyond it, which sees them from the other side.
void BlockContour::handOver(
  const Piece& piece, int face, const PieceKey& to, const FaceSegments& segments, ContourPart& part)
{
  for (int i = 0; i < segments.count; ++i)
  {
    part.lines.push_back({ to, pointOn(piece, segments.to[i], part), pointOn(piece, segments.from[i], part),
      isComplete(to) ? TransitionLine::ownFace : face ^ 1 });
  }
}

/// Where lines that come from the finer side must begin and end.
void BlockContour::askFiner(const Piece& piece, int face, const PieceKey& key, ContourPart& part)
{
  const OctantTables::Face& f = octantTables.face[face];
  for (int i = 0; i < 4; ++i)
  {
    const bool first = piece.inside >> f.corner[i] & 1;
    const bool second = piece.inside >> f.corner[(i + 1) % 4] & 1;
    if (first != second)
    {
      const std::int64_t point = pointOn(piece, f.edge[i], part);
      part.lines.push_back(
        { key, second ? point : TransitionLine::none, second ? TransitionLine::none : point, face });
    }
  }
}

/// Whether smaller pieces at a piece's faces cover them.
bool BlockContour::isComplete(const PieceKey& key) const noexcept
{
  return noneMissing_ || (key.width == 2 && !wholeLeaves_); // dual cells lie between leaves
}

PieceKey BlockContour::keyOf(const Place& low, int width) const noexcept
{
  return { depth_, width, { base_[0] + low[0], base_[1] + low[1], base_[2] + low[2] } };
}

/// The octant beyond a face of an octant, should it have the same size.
PieceKey BlockContour::neighbour(const Piece& piece, int face) const noexcept
{
  PieceKey key = keyOf(piece.low, 1);
  key.index[face >> 1] += face & 1 ? 1 : -1;
  return key;
}

std::array<double, 3> BlockContour::localPoint(int edge) const noexcept
{
  const OctantTables::Edge& e = octantTables.edge[edge];
  std::array<double, 3> p{ double(e.low & 1), double(e.low >> 1 & 1), double(e.low >> 2) };
  p[e.axis] = crossing(values_, edge);
  return p;
}

std::uint32_t BlockContour::addPoint(
  const Piece& piece, const std::array<double, 3>& local, ContourPart& part)
{
  std::array<double, 3> p;
  for (int a = 0; a < 3; ++a)
  {
    const double low = plane_[a][piece.low[a] + 1];
    const double high = plane_[a][piece.low[a] + piece.width + 1];
    p[a] = local[a] == 1. ? high : low + local[a] * (high - low);
  }
  part.points.push_back(p);
  return static_cast<std::uint32_t>(part.points.size() - 1);
}

/// The point on an edge of a piece with the current values.
std::uint32_t BlockContour::pointOn(const Piece& piece, int edge, ContourPart& part)
{
  const OctantTables::Edge& e = octantTables.edge[edge];
  Place low;
  for (int a = 0; a < 3; ++a)
  {
    low[a] = piece.low[a] + piece.width * (e.low >> a & 1);
  }
  std::int32_t& known = piece.width == 1
    ? pointOfEdge_[block::vertexCount * e.axis + block::vertexIndex(low[0], low[1], low[2])]
    : pointOfWideEdge_[64 * e.axis + (low[0] + 1) / 2 + 4 * ((low[1] + 1) / 2) + 16 * ((low[2] + 1) / 2)];
  if (known < 0)
  {
    known = static_cast<std::int32_t>(addPoint(piece, localPoint(edge), part));
    nameCrossing(piece, edge, known, part);
  }
  return static_cast<std::uint32_t>(known);
}

void BlockContour::nameCrossing(const Piece& piece, int edge, std::int64_t point, ContourPart& part) const
{
  const OctantTables::Edge& e = octantTables.edge[edge];
  const int b = (e.axis + 1) % 3;
  const int c = (e.axis + 2) % 3;
  Place low; // end, in the block
  for (int a = 0; a < 3; ++a)
  {
    low[a] = piece.low[a] + piece.width * (e.low >> a & 1);
  }
  SharedCrossing shared;
  shared.size = finestDepth_ - depth_ + piece.width - 1;
  shared.point = point;
  const auto name = [&](Coord middle, int unit) {
    shared.middle[e.axis] = middle << unit;
    shared.middle[b] = (base_[b] + low[b]) << (1 + finestDepth_ - depth_);
    shared.middle[c] = (base_[c] + low[c]) << (1 + finestDepth_ - depth_);
    part.shared.push_back(shared);
  };
  // The line between the centres of two leaves of one size is the edge of dual cells and named by its middle,
  // a vertex.
  const int unit = 1 + finestDepth_ - depth_; // log2 of an octant in half widths of the finest ones
  if (!piece.leaf)
  {
    name(base_[e.axis] + low[e.axis] + 1, unit);
    return;
  }
  const int side = piece.low[e.axis] & 1;
  const bool fromCentre = (low[b] & 1) && (low[c] & 1);
  if (fromCentre && (piece.leaf->same >> entryOfFace(2 * e.axis + side) & 1))
  {
    name(base_[e.axis] + low[e.axis] + side, unit);
    return;
  }
  if (alone_ && low[b] % 4 != 0 && low[c] % 4 != 0)
  {
    return;
  }
  const int wide = piece.width - 1;
  int up = 0;
  if (piece.leaf->coarse != 0)
  {
    // To the entries beside the edge, 0 where it is inside the leaf.
    const auto step = [&](int a) {
      const int upper = e.low >> a & 1;
      const bool isInside = piece.width == 1 && (piece.low[a] & 1) != upper;
      return isInside ? 0 : upper ? entryStride[a] : -entryStride[a];
    };
    for (const int entry : { 13 + step(b), 13 + step(c), 13 + step(b) + step(c) })
    {
      const int more = piece.leaf->up[entry];
      const Coord rest = (Coord(1) << more) - 1;
      if ((piece.leaf->coarse >> entry & 1) &&
        (((base_[b] + low[b]) | (base_[c] + low[c])) >> wide & rest) == 0)
      {
        up = std::max(up, more);
      }
    }
  }
  name(2 * ((base_[e.axis] + low[e.axis]) >> (up + wide)) + 1, up + wide + unit - 1);
}

void BlockContour::fillLoops(const Piece& piece, std::array<std::int8_t, 12>& next, ContourPart& part)
{
  for (int first = 0; first < 12; ++first)
  {
    if (next[first] < 0)
    {
      continue;
    }
    std::array<int, 12> loop;
    int count = 0;
    for (int e = first; next[e] >= 0;)
    {
      loop[count++] = e;
      const int to = next[e];
      next[e] = -1;
      e = to;
    }
    fillLoop(piece, loop, count, part);
  }
}

void BlockContour::fillLoop(const Piece& piece, const std::array<int, 12>& loop, int count, ContourPart& part)
{
  std::array<std::uint32_t, 12> points;
  for (int i = 0; i < count; ++i)
  {
    points[i] = pointOn(piece, loop[i], part);
  }
  if (count == 3)
  {
    part.triangles.push_back({ points[0], points[1], points[2] });
    return;
  }
  std::array<std::array<double, 3>, 12> local{};
  std::array<std::uint8_t, 12> faces{};
  for (int i = 0; i < count; ++i)
  {
    local[i] = localPoint(loop[i]);
    faces[i] = octantTables.edge[loop[i]].faces;
  }
  const int apex = fanApex(local.data(), faces.data(), count);
  if (apex >= 0)
  {
    for (int i = 1; i + 1 < count; ++i)
    {
      part.triangles.push_back({ points[apex], points[(apex + i) % count], points[(apex + i + 1) % count] });
    }
    return;
  }
  const std::array<double, 3> centre = loopCentre(values_, local.data(), count);
  const std::uint32_t point = addPoint(piece, centre, part);
  for (int i = 0; i < count; ++i)
  {
    part.triangles.push_back({ points[i], points[(i + 1) % count], point });
  }
}

} // namespace treeamr
