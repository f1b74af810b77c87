#include "SharedArrays.h"

#include "CornerArrays.h"
#include "Error.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMultiProcessController.h"
#include "vtkMultiProcessStream.h"

#include <algorithm>

namespace treeamr
{

namespace
{

/// Of numbers of whole bytes.
vtkDataArray* sendable(vtkAbstractArray* array)
{
  auto* const numbers = vtkDataArray::FastDownCast(array);
  return numbers && numbers->GetDataTypeSize() > 0 && numbers->GetDataType() != VTK_BIT ? numbers : nullptr;
}

SharedArray describe(vtkDataArray& array, bool isActive)
{
  SharedArray shared{ array.GetName(), array.GetDataType(), array.GetNumberOfComponents(), isAtCorners(array),
    isActive, {}, static_cast<std::size_t>(array.GetNumberOfComponents() * array.GetDataTypeSize()) };
  for (int c = 0; c < shared.components && array.HasAComponentName(); ++c)
  {
    const char* const name = array.GetComponentName(c);
    shared.componentNames.emplace_back(name ? name : "");
  }
  return shared;
}

std::vector<SharedArray> describeAll(vtkHyperTreeGrid& grid, const std::vector<std::string>& names)
{
  std::vector<SharedArray> all;
  vtkCellData* const cells = grid.GetCellData();
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    vtkDataArray* const array = sendable(cells->GetAbstractArray(i));
    const std::string name = array && array->GetName() ? array->GetName() : "";
    const bool isWanted = names.empty() || std::ranges::find(names, name) != names.end();
    if (!name.empty() && name != vtkDataSetAttributes::GhostArrayName() && isWanted)
    {
      all.push_back(describe(*array, cells->GetScalars() == array));
    }
  }
  return all;
}

void broadcast(const ProcessGroup& group, std::vector<SharedArray>& arrays, int from)
{
  vtkMultiProcessStream stream;
  if (group.own() == from)
  {
    stream << static_cast<int>(arrays.size());
    for (const SharedArray& array : arrays)
    {
      stream << array.name << array.type << array.components << static_cast<int>(array.isAtCorners)
             << static_cast<int>(array.isActive) << static_cast<int>(array.tupleBytes)
             << static_cast<int>(array.componentNames.size());
      for (const std::string& name : array.componentNames)
      {
        stream << name;
      }
    }
  }
  group.controller().Broadcast(stream, from);
  group.together([&] {
    if (group.own() == from)
    {
      return;
    }
    int count = 0;
    stream >> count;
    arrays.resize(static_cast<std::size_t>(count));
    for (SharedArray& array : arrays)
    {
      int atCorners = 0;
      int active = 0;
      int bytes = 0;
      int names = 0;
      stream >> array.name >> array.type >> array.components >> atCorners >> active >> bytes >> names;
      array.isAtCorners = atCorners != 0;
      array.isActive = active != 0;
      array.tupleBytes = static_cast<std::size_t>(bytes);
      array.componentNames.resize(static_cast<std::size_t>(names));
      for (std::string& name : array.componentNames)
      {
        stream >> name;
      }
    }
  });
}

/// One that holds its values one after the other.
vtkSmartPointer<vtkDataArray> plain(vtkDataArray& array)
{
  if (array.HasStandardMemoryLayout())
  {
    return &array;
  }
  const auto copy = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(array.GetDataType()));
  copy->DeepCopy(&array);
  return copy;
}

} // namespace

vtkSmartPointer<vtkDataArray> SharedArray::make() const
{
  const auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type));
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  for (int c = 0; c < static_cast<int>(componentNames.size()); ++c)
  {
    array->SetComponentName(c, componentNames[static_cast<std::size_t>(c)].c_str());
  }
  if (isAtCorners)
  {
    markAsCorners(*array);
  }
  return array;
}

SharedArrays::SharedArrays(const ProcessGroup& group, vtkHyperTreeGrid* grid, vtkIdType tuples, int first,
  const std::vector<std::string>& names)
{
  group.together([&] {
    if (grid && group.own() == first)
    {
      arrays_ = describeAll(*grid, names);
    }
  });
  broadcast(group, arrays_, first);

  std::vector<unsigned char> differs;
  group.together([&] {
    differs.resize(arrays_.size(), 0);
    for (std::size_t a = 0; grid && a < arrays_.size(); ++a)
    {
      const SharedArray& shared = arrays_[a];
      vtkDataArray* const array = sendable(grid->GetCellData()->GetAbstractArray(shared.name.c_str()));
      differs[a] = !array || array->GetDataType() != shared.type ||
        array->GetNumberOfComponents() != shared.components || isAtCorners(*array) != shared.isAtCorners;
    }
  });
  std::vector<unsigned char> differsOnAny;
  group.together([&] { differsOnAny = differs; });
  if (!differs.empty())
  {
    group.controller().AllReduce(
      differs.data(), differsOnAny.data(), static_cast<vtkIdType>(differs.size()), vtkCommunicator::MAX_OP);
  }
  group.together([&] {
    std::vector<SharedArray> kept;
    for (std::size_t a = 0; a < arrays_.size(); ++a)
    {
      if (!differsOnAny[a])
      {
        kept.push_back(std::move(arrays_[a]));
      }
    }
    arrays_ = std::move(kept);
    vtkCellData* const cells = grid ? grid->GetCellData() : nullptr;
    for (int i = 0; cells && i < cells->GetNumberOfArrays(); ++i)
    {
      const std::string name = cells->GetArrayName(i) ? cells->GetArrayName(i) : "";
      const bool isWanted = names.empty() || std::ranges::find(names, name) != names.end();
      if (isWanted && name != vtkDataSetAttributes::GhostArrayName() &&
        std::ranges::find(arrays_, name, &SharedArray::name) == arrays_.end())
      {
        leftOut_.push_back("cell array '" + name + "' " +
          (sendable(cells->GetAbstractArray(i)) ? "is not alike on all processes" : "is not of numbers"));
      }
    }
    for (std::size_t a = 0; grid && a < arrays_.size(); ++a)
    {
      vtkDataArray& array = *cells->GetArray(arrays_[a].name.c_str());
      if (array.GetNumberOfTuples() < tuples)
      {
        throw Error("hyper tree grid: cell array '" + arrays_[a].name + "' has " +
          std::to_string(array.GetNumberOfTuples()) + " tuples, allowed are " + std::to_string(tuples) +
          ", one a cell");
      }
      values_.push_back(plain(array));
    }
  });
}

void SharedArrays::add(vtkDataArray& array)
{
  arrays_.push_back(describe(array, false));
  values_.emplace_back(&array);
}

ContentDigest SharedArrays::digest() const
{
  ContentDigest digest;
  for (std::size_t a = 0; a < values_.size(); ++a)
  {
    digest.addBytes(values_[a]->GetVoidPointer(0),
      arrays_[a].tupleBytes * static_cast<std::size_t>(values_[a]->GetNumberOfTuples()));
  }
  return digest;
}

void SharedArrays::copyTuple(std::size_t array, vtkIdType tuple, int turned, std::byte* to) const
{
  const SharedArray& shared = arrays_[array];
  const auto* const from = static_cast<const std::byte*>(values_[array]->GetVoidPointer(0)) +
    static_cast<std::size_t>(tuple) * shared.tupleBytes;
  if (turned == 0 || !shared.isAtCorners)
  {
    std::memcpy(to, from, shared.tupleBytes);
    return;
  }
  const std::size_t bytes = shared.tupleBytes / cornerCount;
  for (int c = 0; c < cornerCount; ++c) // as the corners are along increasing coordinates
  {
    std::memcpy(
      to + static_cast<std::size_t>(c) * bytes, from + static_cast<std::size_t>(c ^ turned) * bytes, bytes);
  }
}

CellBlock::CellBlock(std::size_t count, std::size_t keyBytes, const std::vector<SharedArray>& arrays)
  : count_(count)
  , bytes_(layOut(keyBytes, arrays))
{
  const std::uint64_t written = count;
  std::memcpy(bytes_.data(), &written, sizeof(written));
}

CellBlock::CellBlock(Bytes bytes, std::size_t keyBytes, const std::vector<SharedArray>& arrays)
  : bytes_(std::move(bytes))
{
  std::uint64_t count = 0;
  if (!bytes_.empty())
  {
    std::memcpy(&count, bytes_.data(), sizeof(count));
  }
  count_ = static_cast<std::size_t>(count);
  if (const std::size_t size = layOut(keyBytes, arrays); !bytes_.empty() && size != bytes_.size())
  {
    throw Error("message of " + std::to_string(bytes_.size()) + " bytes, allowed " + std::to_string(size) +
      " for " + std::to_string(count) + " cells");
  }
}

/// Returns how many bytes there are.
std::size_t CellBlock::layOut(std::size_t keyBytes, const std::vector<SharedArray>& arrays)
{
  constexpr std::size_t alignment = 8;
  std::size_t size = sizeof(std::uint64_t) + count_ * keyBytes;
  for (const SharedArray& array : arrays)
  {
    starts_.push_back(size);
    size += (count_ * array.tupleBytes + alignment - 1) / alignment * alignment;
  }
  return size;
}

vtkSmartPointer<vtkCellData> CellBlock::cellData(const std::vector<SharedArray>& arrays)
{
  auto data = vtkSmartPointer<vtkCellData>::New();
  for (std::size_t a = 0; a < arrays.size(); ++a)
  {
    const vtkSmartPointer<vtkDataArray> array = arrays[a].make();
    if (count_ > 0)
    {
      constexpr int isKept = 1;
      array->SetVoidArray(tuples(a), static_cast<vtkIdType>(count_) * arrays[a].components, isKept);
    }
    data->AddArray(array);
  }
  return data;
}

} // namespace treeamr
