// A loop's range cut for threads, the same way each time: what one pass keeps for a part the next finds.
#pragma once

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace treeamr
{

/// [0, count) in equal parts, short enough for many threads, long enough for what is kept per part.
class Parts
{
public:
  explicit Parts(std::size_t count)
    : count_(count)
    , length_(std::max(std::size_t(1) << 14, count / 1024 + 1))
  {
  }
  std::size_t size() const { return (count_ + length_ - 1) / length_; }
  std::size_t begin(std::size_t part) const { return part * length_; }
  std::size_t end(std::size_t part) const { return std::min(count_, begin(part) + length_); }

  /// body(part) for each, in parallel.
  template <class Body>
  void forEach(const Body& body) const
  {
    tbb::parallel_for(std::size_t(0), size(), body);
  }

private:
  std::size_t count_;
  std::size_t length_;
};

} // namespace treeamr
