#include "Contour/Transitions.h"

#include "Contour/MortonSort.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <span>

namespace treeamr
{

namespace
{

using Lines = std::span<const TransitionLine>;

struct Segment
{
  std::int64_t from;
  std::int64_t to;

  auto operator<=>(const Segment&) const noexcept = default;
};

bool isWhole(const TransitionLine& line) noexcept
{
  return line.from != TransitionLine::none && line.to != TransitionLine::none;
}

/// What some pieces add.
struct Closed
{
  std::vector<std::array<std::int64_t, 3>> triangles; // of points of the mesh or ~ a centre
  std::vector<std::array<double, 3>> centres;
  std::vector<ContourMesh::Block> blocks; // of the centres
};

class Closing
{
public:
  Closing(
    const RootGrid& grid, const ContourMesh& mesh, const std::vector<PieceValues>& values, Closed& closed)
    : grid_(grid)
    , mesh_(mesh)
    , values_(values)
    , closed_(closed)
  {
  }

  /// lines: those of one piece, sorted.
  void close(Lines lines)
  {
    segments_.clear();
    for (auto at = lines.begin(); at != lines.end();)
    {
      const auto end =
        std::find_if(at, lines.end(), [face = at->face](const TransitionLine& l) { return l.face != face; });
      for (auto line = at; line != end; ++line)
      {
        if (isWhole(*line))
        {
          segments_.push_back({ line->from, line->to });
        }
      }
      if (at->face >= 0)
      {
        completeFace({ at, end });
      }
      at = end;
    }
    const PieceKey& key = lines.front().piece;
    // Lines on a piece without a crossing of its own are rounding around vertices at the isovalue.
    const bool hasValues = lines.front().face == TransitionLine::valuesFace;
    pieceValues_ = hasValues ? values_[lines.front().from] : PieceValues{};
    const std::size_t firstCentre = closed_.centres.size();
    link(key);
    if (closed_.centres.size() > firstCentre)
    {
      closed_.blocks.push_back({ { key.index[0] >> 2, key.index[1] >> 2, key.index[2] >> 2 }, key.depth - 2,
        static_cast<std::int64_t>(firstCentre) });
    }
  }

private:
  /// On parts of a face where the finer neighbour has no cells its lines are missing: between their loose
  /// ends there are straight lines.
  void completeFace(Lines lines)
  {
    std::vector<std::pair<std::int64_t, int>> ends; // point, missing lines from it less missing lines to it
    const auto add = [&](std::int64_t point, int missing) {
      if (point != TransitionLine::none)
      {
        ends.emplace_back(point, missing);
      }
    };
    for (const TransitionLine& line : lines)
    {
      const bool whole = isWhole(line);
      add(line.from, whole ? -1 : 1);
      add(line.to, whole ? 1 : -1);
    }
    std::sort(ends.begin(), ends.end());
    std::vector<std::int64_t> from;
    std::vector<std::int64_t> to;
    for (auto at = ends.begin(); at != ends.end();)
    {
      int missing = 0;
      const std::int64_t point = at->first;
      for (; at != ends.end() && at->first == point; ++at)
      {
        missing += at->second;
      }
      if (missing != 0)
      {
        auto& list = missing > 0 ? from : to;
        list.insert(list.end(), std::abs(missing), point);
      }
    }
    if (from.empty())
    {
      return;
    }
    // A bilinear function has no closed contour lines: none is led back to its own beginning as long as there
    // is a choice. So those that end on the face, not on its edges, choose first.
    std::vector<Segment> face;
    for (const TransitionLine& line : lines)
    {
      if (isWhole(line))
      {
        face.push_back({ line.from, line.to });
      }
    }
    const auto lineTo = [&](std::int64_t point) {
      return std::find_if(face.begin(), face.end(), [=](const Segment& s) { return s.to == point; });
    };
    std::stable_partition(
      from.begin(), from.end(), [&](std::int64_t point) { return lineTo(point) == face.end(); });
    while (!from.empty() && !to.empty())
    {
      const std::int64_t end = from.back();
      std::int64_t beginning = end;
      auto line = lineTo(end);
      for (std::size_t steps = 0; line != face.end() && steps < face.size(); ++steps)
      {
        beginning = line->from;
        line = lineTo(beginning);
      }
      const auto next = std::min_element(to.begin(), to.end(), [&](std::int64_t p, std::int64_t q) {
        return std::pair(p == beginning, squaredDistance(end, p)) <
          std::pair(q == beginning, squaredDistance(end, q));
      });
      face.push_back({ end, *next });
      segments_.push_back(face.back());
      from.pop_back();
      to.erase(next);
    }
  }

  double squaredDistance(std::int64_t p, std::int64_t q) const noexcept
  {
    double sum = 0.;
    for (int a = 0; a < 3; ++a)
    {
      const double d = mesh_.points[p][a] - mesh_.points[q][a];
      sum += d * d;
    }
    return sum;
  }

  /// Follows the lines around the piece. A loop that comes back to one of its points is two.
  void link(const PieceKey& key)
  {
    std::sort(segments_.begin(), segments_.end());
    std::vector<bool> used(segments_.size());
    std::vector<std::int64_t> chain;
    for (std::size_t first = 0; first < segments_.size(); ++first)
    {
      if (used[first])
      {
        continue;
      }
      chain.assign(1, segments_[first].from);
      for (std::size_t s = first; s < segments_.size() && !used[s];)
      {
        used[s] = true;
        const std::int64_t point = segments_[s].to;
        const auto before = std::find(chain.begin(), chain.end(), point);
        if (before != chain.end())
        {
          addLoop(key, { before, chain.end() });
          chain.erase(before, chain.end());
        }
        chain.push_back(point);
        s = static_cast<std::size_t>(
          std::lower_bound(segments_.begin(), segments_.end(), Segment{ point, 0 }) - segments_.begin());
        while (s < segments_.size() && used[s])
        {
          ++s;
        }
        if (s < segments_.size() && segments_[s].from != point)
        {
          break;
        }
      }
      addLoop(key, chain);
    }
  }

  void addLoop(const PieceKey& key, std::span<const std::int64_t> loop)
  {
    const std::size_t count = loop.size();
    if (count < 3)
    {
      return;
    }
    std::array<double, 3> low;
    std::array<double, 3> width;
    local_.resize(count);
    faces_.assign(count, 0);
    for (int a = 0; a < 3; ++a)
    {
      low[a] = grid_.nodePlane(a, key.index[a], key.depth);
      const double high = grid_.nodePlane(a, key.index[a] + key.width, key.depth);
      width[a] = high - low[a];
      for (std::size_t i = 0; i < count; ++i)
      {
        const double p = mesh_.points[loop[i]][a];
        local_[i][a] = (p - low[a]) / width[a];
        faces_[i] |= static_cast<std::uint8_t>((p == low[a]) << 2 * a | (p == high) << (2 * a + 1));
      }
    }
    const int apex = fanApex(local_.data(), faces_.data(), static_cast<int>(count));
    if (apex >= 0)
    {
      for (std::size_t i = 1; i + 1 < count; ++i)
      {
        closed_.triangles.push_back({ loop[apex], loop[(apex + i) % count], loop[(apex + i + 1) % count] });
      }
      return;
    }
    const auto number = static_cast<std::int64_t>(closed_.centres.size());
    for (std::size_t i = 0; i < count; ++i)
    {
      closed_.triangles.push_back({ loop[i], loop[(i + 1) % count], ~number });
    }
    const std::array<double, 3> local = loopCentre(pieceValues_, local_.data(), static_cast<int>(count));
    std::array<double, 3>& centre = closed_.centres.emplace_back();
    for (int a = 0; a < 3; ++a)
    {
      centre[a] = low[a] + local[a] * width[a];
    }
  }

  const RootGrid& grid_;
  const ContourMesh& mesh_;
  const std::vector<PieceValues>& values_;
  Closed& closed_;
  PieceValues pieceValues_;
  std::vector<Segment> segments_;
  // Of the current loop.
  std::vector<std::array<double, 3>> local_;
  std::vector<std::uint8_t> faces_;
};

/// Puts the centres behind the mesh's points.
void append(std::vector<Closed>& closed, ContourMesh& mesh)
{
  std::vector<std::size_t> firstCentre{ mesh.points.size() };
  std::vector<std::size_t> firstTriangle{ mesh.triangles.size() };
  for (const Closed& c : closed)
  {
    firstCentre.push_back(firstCentre.back() + c.centres.size());
    firstTriangle.push_back(firstTriangle.back() + c.triangles.size());
    for (ContourMesh::Block block : c.blocks)
    {
      block.firstPoint += static_cast<std::int64_t>(firstCentre[firstCentre.size() - 2]);
      mesh.blocks.push_back(block);
    }
  }
  mesh.points.resize(firstCentre.back());
  mesh.triangles.resize(firstTriangle.back());
  tbb::parallel_for(std::size_t(0), closed.size(), [&](std::size_t i) {
    std::copy(closed[i].centres.begin(), closed[i].centres.end(), mesh.points.begin() + firstCentre[i]);
    auto* to = mesh.triangles.data() + firstTriangle[i];
    for (const auto& triangle : closed[i].triangles)
    {
      for (int c = 0; c < 3; ++c)
      {
        (*to)[c] = triangle[c] >= 0 ? triangle[c] : static_cast<std::int64_t>(firstCentre[i]) + ~triangle[c];
      }
      ++to;
    }
    closed[i] = {};
  });
}

} // namespace

void closeTransitions(const RootGrid& grid, int octantDepth, const std::optional<LatticeBox>& box,
  std::vector<TransitionLine>& lines, const std::vector<PieceValues>& values, ContourMesh& mesh)
{
  sortByPlace(lines, octantDepth, [=](const TransitionLine& line) {
    std::array<Coord, 3> place = line.piece.index;
    for (Coord& p : place)
    {
      p <<= octantDepth - line.piece.depth;
    }
    return place;
  });
  constexpr std::size_t chunk = 4096; // lines
  std::vector<Closed> closed((lines.size() + chunk - 1) / chunk);
  tbb::parallel_for(std::size_t(0), closed.size(), [&](std::size_t i) {
    Closing closing(grid, mesh, values, closed[i]);
    const auto isFirst = [&](std::size_t l) { return l == 0 || lines[l].piece != lines[l - 1].piece; };
    // Pieces whose first line is in the chunk.
    for (std::size_t l = i * chunk; l < std::min((i + 1) * chunk, lines.size());)
    {
      std::size_t end = l + 1;
      while (end < lines.size() && !isFirst(end))
      {
        ++end;
      }
      if (isFirst(l) && (!box || owns(*box, lines[l].piece, grid.paddingDepth())))
      {
        closing.close({ lines.data() + l, end - l });
      }
      l = end;
    }
  });
  append(closed, mesh);
}

} // namespace treeamr
