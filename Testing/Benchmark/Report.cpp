#include "Report.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <thread>

namespace treeamr::bench
{

namespace
{

constexpr int nameWidth = 16;
constexpr int labelWidth = 23;
constexpr int minColumnWidth = 8;

int columnWidth(const Figure& figure)
{
  return std::max(minColumnWidth, static_cast<int>(std::strlen(figure.heading)));
}

std::string machine()
{
  std::string model = "unknown";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
  {
    if (line.starts_with("model name"))
    {
      model = line.substr(line.find(':') + 2);
      break;
    }
  }
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

} // namespace

void Report::add(Row row)
{
  if (rows_.empty())
  {
    std::printf("%-*s", nameWidth, key_);
    for (const auto& [key, value] : row.labels)
    {
      std::printf("  %-*s", labelWidth, key);
    }
    for (const Figure& f : row.figures)
    {
      if (f.heading)
      {
        std::printf("  %*s", columnWidth(f), f.heading);
      }
    }
    std::printf("\n");
  }
  std::printf("%-*s", nameWidth, row.dataSet.c_str());
  for (const auto& [key, value] : row.labels)
  {
    std::printf("  %-*s", labelWidth, value.c_str());
  }
  for (const Figure& f : row.figures)
  {
    if (f.heading)
    {
      std::printf("  %*.*f", columnWidth(f), f.decimals, f.scale * f.value);
    }
  }
  std::printf("\n");
  std::fflush(stdout);
  rows_.push_back(std::move(row));
}

void writeJson(const std::string& path, const std::vector<const Report*>& reports)
{
  std::ofstream out(path);
  out << std::setprecision(10) << "{\n  \"machine\": \"" << machine() << '"';
  for (const Report* report : reports)
  {
    if (report->rows_.empty())
    {
      continue;
    }
    out << ",\n  \"" << report->key_ << "\": [";
    const char* separator = "\n";
    for (const Row& row : report->rows_)
    {
      out << separator << "    {\"dataset\": \"" << row.dataSet << '"';
      for (const auto& [key, value] : row.labels)
      {
        out << ", \"" << key << "\": \"" << value << '"';
      }
      for (const Figure& f : row.figures)
      {
        if (f.key)
        {
          out << ", \"" << f.key << "\": ";
          if (std::isfinite(f.value))
          {
            out << f.value;
          }
          else
          {
            out << "null"; // JSON has no other
          }
        }
      }
      out << '}';
      separator = ",\n";
    }
    out << "\n  ]";
  }
  out << "\n}\n";
  if (!out.flush())
  {
    throw Error(path + ": cannot be written");
  }
}

} // namespace treeamr::bench
