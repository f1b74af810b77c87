// Measures error against run time on the forests of a folder (those of treeamr-benchmark); CPU seconds are
// those of the whole process on all threads.
//
// treeamr-report FOLDER --json FILE [--brief] [--part volume|functions|field|isosurface|estimate|digits]
//
// Prints tables and writes them to FILE: one list for each part, one row for each setting, and lists of the
// orders at which errors of field and isosurface fall. --brief is for continuous integration: the first data
// set alone, in a small picture, with few settings. Functions, field, isosurface and digits need no forests.
#include "DigitsError.h"
#include "EstimateError.h"
#include "FieldError.h"
#include "FunctionError.h"
#include "IsosurfaceError.h"
#include "Options.h"
#include "Report.h"
#include "VolumeError.h"

#include <cstdio>
#include <exception>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace treeamr::report
{

namespace
{

struct Arguments
{
  Options options;
  std::string json;
  std::string part; // empty: all
};

const std::set<std::string_view> parts{ "volume", "functions", "field", "isosurface", "estimate", "digits" };

/// Nothing when they are not understood.
std::optional<Arguments> parse(int argc, char* argv[])
{
  Arguments arguments;
  for (int i = 1; i < argc; ++i)
  {
    const std::string_view name = argv[i];
    if (name == "--brief")
    {
      arguments.options.brief = true;
    }
    else if (name == "--json" && i + 1 < argc)
    {
      arguments.json = argv[++i];
    }
    else if (name == "--part" && i + 1 < argc)
    {
      arguments.part = argv[++i];
      if (!parts.contains(arguments.part))
      {
        return std::nullopt;
      }
    }
    else if (arguments.options.folder.empty() && !name.starts_with('-'))
    {
      arguments.options.folder = name;
    }
    else
    {
      return std::nullopt;
    }
  }
  if (arguments.options.folder.empty() || arguments.json.empty())
  {
    return std::nullopt;
  }
  return arguments;
}

void run(const Arguments& arguments)
{
  bench::Report volume("volume");
  bench::Report functions("functions");
  bench::Report field("field");
  bench::Report fieldOrders("field_orders");
  bench::Report isosurface("isosurface");
  bench::Report isosurfaceOrders("isosurface_orders");
  bench::Report estimate("estimate");
  bench::Report digits("digits");
  const auto wanted = [&](std::string_view part) { return arguments.part.empty() || arguments.part == part; };
  if (wanted("volume"))
  {
    measureVolumeError(arguments.options, volume);
  }
  if (wanted("functions"))
  {
    measureFunctionError(arguments.options, functions);
  }
  if (wanted("field"))
  {
    measureFieldError(arguments.options, field, fieldOrders);
  }
  if (wanted("isosurface"))
  {
    measureIsosurfaceError(arguments.options, isosurface, isosurfaceOrders);
  }
  if (wanted("estimate"))
  {
    measureErrorEstimate(arguments.options, estimate);
  }
  if (wanted("digits"))
  {
    measureDigits(digits);
  }
  bench::writeJson(arguments.json,
    { &volume, &functions, &field, &fieldOrders, &isosurface, &isosurfaceOrders, &estimate, &digits });
}

} // namespace

} // namespace treeamr::report

int main(int argc, char* argv[])
{
  const auto arguments = treeamr::report::parse(argc, argv);
  if (!arguments)
  {
    std::fprintf(stderr,
      "usage: treeamr-report FOLDER --json FILE [--brief] [--part "
      "volume|functions|field|isosurface|estimate|digits]\n");
    return 2;
  }
  try
  {
    treeamr::report::run(*arguments);
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "treeamr-report: %s\n", error.what());
    return 1;
  }
  return 0;
}
