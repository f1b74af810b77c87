#include "Meter.h"

#include "Error.h"

#include <malloc.h>

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

} // namespace

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
