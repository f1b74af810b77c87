#include "Contour/Transitions.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
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

/// A loop around a centre.
struct Fan
{
  std::vector<std::int64_t> loop;
  std::array<double, 3> centre;
  std::array<float, 3> gradient;
};

/// What one piece adds.
struct Closed
{
  std::vector<std::array<std::int64_t, 3>> triangles;
  std::vector<Fan> fans;
};

class Closing
{
public:
  Closing(const RootGrid& grid, const ContourMesh& mesh, const std::vector<TransitionPiece>& pieces)
    : grid_(grid)
    , mesh_(mesh)
    , pieces_(pieces)
  {
  }

  /// lines: those of one piece, sorted.
  Closed close(Lines lines)
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
      if (at->face != TransitionLine::ownFace)
      {
        completeFace({ at, end });
      }
      at = end;
    }
    Closed closed;
    link(lines.front().piece, closed);
    return closed;
  }

private:
  /// On parts of a face where the finer neighbour has no cells its lines are missing: between their loose ends
  /// there are straight lines.
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
    // A bilinear function has no closed contour lines: none is led back to its own beginning as long as there is
    // a choice. So those that end on the face, not on its edges, choose first.
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
  void link(const PieceKey& key, Closed& closed)
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
          addLoop(key, { before, chain.end() }, closed);
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
      addLoop(key, chain, closed);
    }
  }

  void addLoop(const PieceKey& key, const std::vector<std::int64_t>& loop, Closed& closed) const
  {
    if (loop.size() == 3)
    {
      closed.triangles.push_back({ loop[0], loop[1], loop[2] });
    }
    else if (loop.size() > 3)
    {
      closed.fans.push_back(makeFan(key, loop));
    }
  }

  Fan makeFan(const PieceKey& key, const std::vector<std::int64_t>& loop) const
  {
    const auto found =
      std::lower_bound(pieces_.begin(), pieces_.end(), TransitionPiece{ key, PieceValues{} });
    // Lines on a piece without a crossing of its own are rounding around vertices at the isovalue.
    const PieceValues values = found != pieces_.end() && found->piece == key ? found->values : PieceValues{};
    Bounds box;
    for (int a = 0; a < 3; ++a)
    {
      box.min[a] = grid_.nodePlane(a, key.index[a], key.depth);
      box.max[a] = grid_.nodePlane(a, key.index[a] + key.width, key.depth);
    }
    std::vector<std::array<double, 3>> local(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i)
    {
      for (int a = 0; a < 3; ++a)
      {
        local[i][a] = (mesh_.points[loop[i]][a] - box.min[a]) / (box.max[a] - box.min[a]);
      }
    }
    const std::array<double, 3> centre = loopCentre(values, local.data(), static_cast<int>(loop.size()));
    const std::array<double, 3> gradient = trilinearGradient(values, centre);
    Fan fan{ loop, {}, {} };
    for (int a = 0; a < 3; ++a)
    {
      const double width = box.max[a] - box.min[a];
      fan.centre[a] = box.min[a] + centre[a] * width;
      fan.gradient[a] = static_cast<float>(gradient[a] / width);
    }
    return fan;
  }

  const RootGrid& grid_;
  const ContourMesh& mesh_;
  const std::vector<TransitionPiece>& pieces_;
  std::vector<Segment> segments_;
};

} // namespace

void closeTransitions(const RootGrid& grid, std::vector<TransitionLine>& lines,
  std::vector<TransitionPiece>& pieces, ContourMesh& mesh)
{
  tbb::parallel_sort(lines.begin(), lines.end());
  tbb::parallel_sort(pieces.begin(), pieces.end());
  std::vector<Lines> groups;
  for (auto at = lines.begin(); at != lines.end();)
  {
    const auto end =
      std::find_if(at, lines.end(), [&](const TransitionLine& l) { return l.piece != at->piece; });
    groups.emplace_back(at, end);
    at = end;
  }
  std::vector<Closed> closed(groups.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups.size(), 256), [&](const auto& range) {
    Closing closing(grid, mesh, pieces);
    for (std::size_t g = range.begin(); g != range.end(); ++g)
    {
      closed[g] = closing.close(groups[g]);
    }
  });
  const bool gradients = !mesh.gradients.empty();
  for (std::size_t g = 0; g < groups.size(); ++g)
  {
    mesh.triangles.insert(mesh.triangles.end(), closed[g].triangles.begin(), closed[g].triangles.end());
    if (closed[g].fans.empty())
    {
      continue;
    }
    const PieceKey& key = groups[g].front().piece;
    mesh.blocks.push_back({ { key.index[0] >> 2, key.index[1] >> 2, key.index[2] >> 2 }, key.depth - 2,
      static_cast<std::int64_t>(mesh.points.size()) });
    for (const Fan& fan : closed[g].fans)
    {
      const auto centre = static_cast<std::int64_t>(mesh.points.size());
      mesh.points.push_back(fan.centre);
      if (gradients)
      {
        mesh.gradients.push_back(fan.gradient);
      }
      for (std::size_t i = 0; i < fan.loop.size(); ++i)
      {
        mesh.triangles.push_back({ fan.loop[i], fan.loop[(i + 1) % fan.loop.size()], centre });
      }
    }
  }
}

} // namespace treeamr
