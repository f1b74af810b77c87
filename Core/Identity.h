// Numbers that tell objects apart, also after they are gone and another lies at their address.
#pragma once

#include <atomic>
#include <cstdint>

namespace treeamr
{

/// A number that no other object of this process has. Copies of an object share it, so it belongs to what never
/// changes after construction.
class Identity
{
public:
  Identity() noexcept
  {
    static std::atomic<std::uint64_t> last{ 0 };
    number_ = ++last;
  }
  bool operator==(const Identity&) const noexcept = default;

private:
  std::uint64_t number_;
};

} // namespace treeamr
