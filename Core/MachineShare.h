// What several processes on one machine may keep in its memory, divided among them.
#pragma once

#include <cstddef>

namespace treeamr
{

/// How many there are, at least 1 (default), this one included. For what is kept from then on.
void setProcessesOnMachine(int count) noexcept;

/// Of the bytes that a process alone may keep, what this one may.
std::size_t shareOfMachine(std::size_t bytes) noexcept;

} // namespace treeamr
