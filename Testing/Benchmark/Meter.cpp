#include "Meter.h"

#include "Error.h"

#include <malloc.h>
#include <sys/resource.h>

#include <chrono>
#include <fstream>
#include <string>

namespace treeamr::bench
{

namespace
{

/// A value in KiB of /proc/self/status.
std::size_t statusBytes(const std::string& key)
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
  {
    if (line.starts_with(key + ":"))
    {
      return std::stoull(line.substr(key.size() + 1)) * 1024;
    }
  }
  throw Error("/proc/self/status: no " + key);
}

double seconds(const timeval& t)
{
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

} // namespace

Cost spent()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now().time_since_epoch();
  const double system = seconds(usage.ru_stime);
  return { wall.count(), seconds(usage.ru_utime) + system, system, static_cast<double>(usage.ru_minflt) };
}

std::size_t residentBytes()
{
  malloc_trim(0);
  return statusBytes("VmRSS");
}

std::size_t takePeakResidentBytes()
{
  const std::size_t peak = statusBytes("VmHWM");
  std::ofstream("/proc/self/clear_refs") << 5; // resets the peak
  return peak;
}

} // namespace treeamr::bench
