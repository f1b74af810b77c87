// Time and memory of this process (Linux).
#pragma once

#include <algorithm>
#include <cstddef>

namespace treeamr::bench
{

struct Cost
{
  double wall = 0.;   // seconds
  double cpu = 0.;    // of all threads
  double system = 0.; // of these
  double faults = 0.; // pages that the system had to make
};

/// Since the process began; wall: since whenever.
Cost spent();

template <class Work>
Cost measure(const Work& work)
{
  const Cost before = spent();
  work();
  const Cost after = spent();
  return { after.wall - before.wall, after.cpu - before.cpu, after.system - before.system,
    after.faults - before.faults };
}

template <class Prepare, class Work>
Cost best(const Prepare& prepare, const Work& work, int atLeast = 3, int atMost = 10)
{
  prepare();
  Cost least = measure(work);
  double wall = least.wall;
  for (int runs = 1; runs < atLeast || (runs < atMost && wall < 3.); ++runs)
  {
    prepare();
    const Cost c = measure(work);
    wall += c.wall;
    least = { std::min(least.wall, c.wall), std::min(least.cpu, c.cpu), std::min(least.system, c.system),
      std::min(least.faults, c.faults) };
  }
  return least;
}
template <class Work>
Cost best(const Work& work)
{
  return best([] {}, work);
}

/// Resident bytes; what is freed has been given back to the system before.
std::size_t residentBytes();
/// The most that residentBytes() was since the last call of this.
std::size_t takePeakResidentBytes();

} // namespace treeamr::bench
