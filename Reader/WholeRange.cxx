#include "WholeRange.h"

#include "CornerArrays.h"
#include "ProcessGroup.h"

#include "vtkCellData.h"
#include "vtkCommunicator.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace treeamr
{

namespace
{

/// Of the field data: a tuple for the magnitude and one for each component.
std::string fieldName(const std::string& array)
{
  return "TreeAMRWholeRange " + array;
}

using Ranges = std::vector<double>; // least and negative greatest of the magnitude and of each component

std::map<std::string, Ranges> rangesOf(vtkHyperTreeGrid* grid)
{
  std::map<std::string, Ranges> all;
  vtkCellData* const cells = grid ? grid->GetCellData() : nullptr;
  for (int i = 0; cells && i < cells->GetNumberOfArrays(); ++i)
  {
    vtkDataArray* const array = cells->GetArray(i);
    const std::string name = array && array->GetName() ? array->GetName() : "";
    if (name.empty() || name == vtkDataSetAttributes::GhostArrayName() || array->GetNumberOfTuples() == 0 ||
      isAtCorners(*array))
    {
      continue;
    }
    Ranges& ranges = all[name];
    const int components = array->GetNumberOfComponents();
    for (int c = components == 1 ? 0 : -1; c < components; ++c)
    {
      std::array<double, 2> range{};
      array->GetFiniteRange(range.data(), c);
      const bool isEmpty = !(range[0] <= range[1]);
      constexpr double none = std::numeric_limits<double>::infinity();
      ranges.push_back(isEmpty ? none : range[0]);
      ranges.push_back(isEmpty ? none : -range[1]);
    }
  }
  return all;
}

/// Names and how many numbers each has, of all processes: as text, for the controller sends bytes.
std::map<std::string, std::size_t> namesOfAll(
  const ProcessGroup& group, const std::map<std::string, Ranges>& own)
{
  std::vector<Bytes> messages(static_cast<std::size_t>(group.size()));
  group.together([&] {
    Bytes names;
    for (const auto& [name, ranges] : own)
    {
      const std::string line = std::to_string(ranges.size()) + ' ' + name + '\0';
      const auto* const begin = reinterpret_cast<const std::byte*>(line.data());
      names.insert(names.end(), begin, begin + line.size());
    }
    std::ranges::fill(messages, names);
  });
  messages = group.exchange(std::move(messages));
  std::map<std::string, std::size_t> all;
  group.together([&] {
    for (const Bytes& message : messages)
    {
      const auto* text = reinterpret_cast<const char*>(message.data());
      const char* const end = text + message.size();
      while (text < end)
      {
        const std::string line(text);
        const std::size_t space = line.find(' ');
        std::size_t& count = all[line.substr(space + 1)];
        count = std::max(count, static_cast<std::size_t>(std::stoul(line)));
        text += line.size() + 1;
      }
    }
  });
  return all;
}

} // namespace

vtkSmartPointer<vtkHyperTreeGrid> withWholeRanges(
  const ProcessGroup& group, vtkHyperTreeGrid* grid, bool mayChange)
{
  std::map<std::string, Ranges> own;
  group.together([&] { own = rangesOf(grid); });
  const std::map<std::string, std::size_t> names = namesOfAll(group, own);
  std::vector<double> least;
  std::vector<double> local;
  group.together([&] {
    for (const auto& [name, count] : names)
    {
      Ranges& ranges = own[name];
      ranges.resize(count, std::numeric_limits<double>::infinity());
      local.insert(local.end(), ranges.begin(), ranges.end());
    }
    least.resize(local.size());
  });
  if (local.empty())
  {
    return grid;
  }
  group.controller().AllReduce(
    local.data(), least.data(), static_cast<vtkIdType>(local.size()), vtkCommunicator::MIN_OP);
  vtkSmartPointer<vtkHyperTreeGrid> result = grid;
  group.together([&] {
    if (!grid)
    {
      return;
    }
    if (!mayChange)
    {
      result = vtk::TakeSmartPointer(grid->NewInstance());
      result->ShallowCopy(grid);
    }
    vtkNew<vtkFieldData> data; // not the grid's, which copies of it have, too
    data->ShallowCopy(grid->GetFieldData());
    result->SetFieldData(data);
    const double* next = least.data();
    for (const auto& [name, count] : names)
    {
      vtkNew<vtkDoubleArray> ranges;
      ranges->SetName(fieldName(name).c_str());
      ranges->SetNumberOfComponents(2);
      for (const double* const end = next + count; next != end; next += 2)
      {
        ranges->InsertNextTuple2(next[0], -next[1]);
      }
      data->AddArray(ranges);
    }
  });
  return result;
}

std::optional<std::array<double, 2>> wholeRange(
  vtkHyperTreeGrid& grid, const std::string& array, int component)
{
  vtkDataArray* const cells = grid.GetCellData()->GetArray(array.c_str());
  vtkDataArray* const ranges = grid.GetFieldData()->GetArray(fieldName(array).c_str());
  if (!cells || !ranges || ranges->GetNumberOfComponents() != 2)
  {
    return std::nullopt;
  }
  const int place = cells->GetNumberOfComponents() == 1 || component < 0 ? 0 : component + 1;
  if (ranges->GetNumberOfTuples() <= place)
  {
    return std::nullopt;
  }
  const std::array<double, 2> range{ ranges->GetComponent(place, 0), ranges->GetComponent(place, 1) };
  return range[0] <= range[1] ? std::optional(range) : std::nullopt;
}

} // namespace treeamr
