#include "PointExchange.h"

#include "Error.h"
#include "GridPartition.h"
#include "HyperTreeGridTopology.h"

#include "Partition/BoxTree.h"

#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Of an array, before its tuples; its name follows.
struct ArrayHead
{
  int type;
  int components;
  std::size_t nameLength;
};

void append(Bytes& bytes, const void* from, std::size_t size)
{
  const auto* const begin = static_cast<const std::byte*>(from);
  bytes.insert(bytes.end(), begin, begin + size);
}

/// Reads what append() has written.
class BytesReader
{
public:
  explicit BytesReader(const Bytes& bytes)
    : at_(bytes.data())
    , end_(bytes.data() + bytes.size())
  {
  }
  bool isAtEnd() const { return at_ == end_; }
  const std::byte* take(std::size_t size)
  {
    if (size > static_cast<std::size_t>(end_ - at_))
    {
      throw Error("probe: an answer of another process ends too early");
    }
    return std::exchange(at_, at_ + size);
  }

private:
  const std::byte* at_;
  const std::byte* end_;
};

std::size_t tupleBytes(vtkDataArray& array)
{
  return static_cast<std::size_t>(array.GetDataTypeSize()) *
    static_cast<std::size_t>(array.GetNumberOfComponents());
}

std::byte* tuplesOf(vtkDataArray& array)
{
  return static_cast<std::byte*>(array.GetVoidPointer(0));
}

/// Of `count` answers from `first` on. Arrays are told without any, too: all processes are to have the same.
Bytes packed(vtkPointData& answers, std::size_t first, std::size_t count)
{
  Bytes bytes;
  for (int i = 0; i < answers.GetNumberOfArrays(); ++i)
  {
    vtkDataArray* const array = answers.GetArray(i);
    const std::string name = array->GetName();
    const ArrayHead head{ array->GetDataType(), array->GetNumberOfComponents(), name.size() };
    append(bytes, &head, sizeof(head));
    append(bytes, name.data(), name.size());
    if (count > 0)
    {
      append(bytes, tuplesOf(*array) + first * tupleBytes(*array), count * tupleBytes(*array));
    }
  }
  return bytes;
}

} // namespace

PointExchange::PointExchange(const ProcessGroup& group, vtkHyperTreeGrid& grid, vtkDataSet& points)
  : group_(group)
  , count_(points.GetNumberOfPoints())
  , sent_(static_cast<std::size_t>(group.size()))
{
  std::vector<Bytes> messages(sent_.size());
  group_.together([&] {
    const auto partition = partitionOf(grid);
    if (!partition || partition->boxes.size() != sent_.size())
    {
      throw Error("probe: the source has no boxes of as many processes as there are");
    }
    const RootGrid roots(readRootPlanes(grid));
    const BoxTree boxes(partition->boxes);
    const int level = partition->box().level;
    for (vtkIdType i = 0; i < count_; ++i)
    {
      std::array<double, 3> point;
      points.GetPoint(i, point.data());
      std::array<Coord, 3> place;
      bool isInside = true;
      for (int a = 0; a < 3; ++a)
      {
        const double at = roots.latticeCoordinate(a, point[a]);
        isInside = isInside && at >= 0.;
        const Coord last = (Coord(roots.roots()[a]) << level) - 1;
        place[a] = isInside ? std::min(static_cast<Coord>(std::ldexp(at, level)), last) : 0;
      }
      const int owner = isInside ? boxes.find(place) : -1;
      if (owner >= 0)
      {
        sent_[static_cast<std::size_t>(owner)].push_back(i);
        append(messages[static_cast<std::size_t>(owner)], point.data(), sizeof(point));
      }
    }
  });
  messages = group_.exchange(std::move(messages));
  group_.together([&] {
    std::size_t all = 0;
    for (const Bytes& message : messages)
    {
      askedOf_.push_back(message.size() / sizeof(std::array<double, 3>));
      all += askedOf_.back();
    }
    vtkNew<vtkPoints> list;
    list->SetDataTypeToDouble();
    list->SetNumberOfPoints(static_cast<vtkIdType>(all));
    auto* to = static_cast<std::byte*>(list->GetVoidPointer(0));
    for (Bytes& message : messages)
    {
      to = std::ranges::copy(message, to).out;
      message = {};
    }
    asked_->SetPoints(list);
  });
}

PointExchange::~PointExchange() = default;

void PointExchange::answer(vtkPointData& answers, vtkPointData& data) const
{
  std::vector<Bytes> messages(sent_.size());
  group_.together([&] {
    std::size_t first = 0;
    for (std::size_t process = 0; process < sent_.size(); ++process)
    {
      messages[process] = packed(answers, first, askedOf_[process]);
      first += askedOf_[process];
    }
  });
  messages = group_.exchange(std::move(messages));
  group_.together([&] {
    for (std::size_t process = 0; process < sent_.size(); ++process)
    {
      BytesReader reader(messages[process]);
      while (!reader.isAtEnd())
      {
        ArrayHead head;
        std::memcpy(&head, reader.take(sizeof(head)), sizeof(head));
        const std::string name(reinterpret_cast<const char*>(reader.take(head.nameLength)), head.nameLength);
        vtkDataArray* array = data.GetArray(name.c_str());
        if (!array)
        {
          auto made = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(head.type));
          made->SetName(name.c_str());
          made->SetNumberOfComponents(head.components);
          made->SetNumberOfTuples(count_);
          const bool isReal = head.type == VTK_FLOAT || head.type == VTK_DOUBLE;
          made->Fill(isReal ? std::numeric_limits<double>::quiet_NaN() : 0.);
          data.AddArray(made);
          array = made;
        }
        if (array->GetDataType() != head.type || array->GetNumberOfComponents() != head.components)
        {
          throw Error("probe: array '" + name + "' is of another type on process " + std::to_string(process));
        }
        const std::size_t size = tupleBytes(*array);
        const std::byte* from = reader.take(size * sent_[process].size());
        for (const vtkIdType point : sent_[process])
        {
          std::memcpy(tuplesOf(*array) + static_cast<std::size_t>(point) * size, from, size);
          from += size;
        }
      }
      messages[process] = {};
    }
  });
}

} // namespace treeamr
