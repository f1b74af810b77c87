#include "MachineShare.h"

#include <algorithm>
#include <atomic>

namespace treeamr
{

namespace
{

std::atomic<std::size_t> processes{ 1 };

} // namespace

void setProcessesOnMachine(int count) noexcept
{
  processes = static_cast<std::size_t>(std::max(1, count));
}

std::size_t shareOfMachine(std::size_t bytes) noexcept
{
  return bytes / processes;
}

} // namespace treeamr
