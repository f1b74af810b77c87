// Time and memory of this process (Linux).
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>

namespace treeamr::bench
{

struct Seconds
{
  double wall;
  double cpu; // of all threads
};

template <class Work>
Seconds measure(const Work& work)
{
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  work();
  return { std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count(),
    static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC };
}

/// The least of both over `atLeast` runs, or up to `atMost` within three seconds: other programs only ever add time.
/// prepare() is not measured.
template <class Prepare, class Work>
Seconds best(const Prepare& prepare, const Work& work, int atLeast = 3, int atMost = 10)
{
  prepare();
  Seconds least = measure(work);
  double spent = least.wall;
  for (int runs = 1; runs < atLeast || (runs < atMost && spent < 3.); ++runs)
  {
    prepare();
    const Seconds s = measure(work);
    spent += s.wall;
    least = { std::min(least.wall, s.wall), std::min(least.cpu, s.cpu) };
  }
  return least;
}
template <class Work>
Seconds best(const Work& work)
{
  return best([] {}, work);
}

/// Resident bytes; what is freed has been given back to the system before.
std::size_t residentBytes();
/// The most that residentBytes() was since the last call of this.
std::size_t takePeakResidentBytes();

} // namespace treeamr::bench
