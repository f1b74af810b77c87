#include "Forest/QuadrantSearch.h"

#include "Forest/P4estForestFile.h"

#include <algorithm>
#include <span>

namespace treeamr
{

QuadrantSearch::QuadrantSearch(const P4estForestFile& file)
  : file_(file)
  , input_(file.path())
  , pages_(pageCount)
{
}

int QuadrantSearch::childOf(std::uint64_t quadrant, int level)
{
  const std::uint64_t number = quadrant / pageQuadrants;
  Page& page = pages_[number % pageCount];
  if (page.number != number)
  {
    const std::uint64_t first = number * pageQuadrants;
    const std::uint64_t count = std::min(pageQuadrants, file_.quadrantCount() - first);
    page.number = ~std::uint64_t(0); // while it is not read
    file_.readAnchors(input_, first, std::span(page.anchors).first(count));
    page.number = number;
  }
  const std::array<std::int32_t, 3>& anchor = page.anchors[quadrant % pageQuadrants];
  const int down = file_.rootBits() - level - 1;
  return down < 0 ? 0 : (anchor[0] >> down & 1) | (anchor[1] >> down & 1) << 1 | (anchor[2] >> down & 1) << 2;
}

LeafRange QuadrantSearch::child(const LeafRange& range, int level, int octant)
{
  const auto firstFrom = [&](std::uint64_t begin, int least) {
    std::uint64_t end = range.end;
    while (begin < end)
    {
      const std::uint64_t middle = begin + (end - begin) / 2;
      if (childOf(middle, level) < least)
      {
        begin = middle + 1;
      }
      else
      {
        end = middle;
      }
    }
    return begin;
  };
  const std::uint64_t begin = firstFrom(range.begin, octant);
  return { begin, octant == 7 ? range.end : firstFrom(begin, octant + 1) };
}

} // namespace treeamr
