// The cell arrays that the grids of several processes have alike, and cells with their tuples as bytes that are sent. Private
// to the module.
#pragma once

#include "BlockArrays.h"
#include "ContentDigest.h"
#include "ProcessGroup.h"

#include "vtkSmartPointer.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkDataArray;
class vtkHyperTreeGrid;

namespace treeamr
{

struct SharedArray
{
  std::string name;
  int type; // VTK's number
  int components;
  bool isAtCorners; // CornerArrays.h
  bool isActive;    // the active scalars
  std::vector<std::string> componentNames;
  std::size_t tupleBytes;

  /// An empty one.
  vtkSmartPointer<vtkDataArray> make() const;
};

class SharedArrays
{
public:
  /// Each process calls it. grid: null where there are no trees. tuples: that an array must have. first: the process whose
  /// arrays are in question. names: of those that are wanted; none: all. Throws Error on all for an array of too few tuples.
  SharedArrays(const ProcessGroup& group, vtkHyperTreeGrid* grid, vtkIdType tuples, int first,
    const std::vector<std::string>& names);

  /// Of this process, an array of one tuple for each of its grid's.
  void add(vtkDataArray& array);

  const std::vector<SharedArray>& arrays() const noexcept { return arrays_; }
  /// What is wrong with others of this process.
  const std::vector<std::string>& leftOut() const noexcept { return leftOut_; }
  /// Of this process' values.
  ContentDigest digest() const;
  /// Of this process. turned: of its grid (turnedAxes()).
  void copyTuple(std::size_t array, vtkIdType tuple, int turned, std::byte* to) const;

private:
  std::vector<SharedArray> arrays_;
  std::vector<vtkSmartPointer<vtkDataArray>> values_; // of this process, none without a grid
  std::vector<std::string> leftOut_;
};

/// Bytes of cells: how many, their keys, and array by array their tuples.
class CellBlock
{
public:
  CellBlock() = default;
  /// Of `count` cells, with undefined keys and tuples.
  CellBlock(std::size_t count, std::size_t keyBytes, const std::vector<SharedArray>& arrays);
  /// That were sent.
  CellBlock(Bytes bytes, std::size_t keyBytes, const std::vector<SharedArray>& arrays);

  std::size_t size() const noexcept { return count_; }
  template <class Key>
  Key* keys() noexcept
  {
    return reinterpret_cast<Key*>(bytes_.data() + sizeof(std::uint64_t));
  }
  template <class Key>
  const Key* keys() const noexcept
  {
    return reinterpret_cast<const Key*>(bytes_.data() + sizeof(std::uint64_t));
  }
  std::byte* tuples(std::size_t array) noexcept { return bytes_.data() + starts_[array]; }
  const std::byte* tuples(std::size_t array) const noexcept { return bytes_.data() + starts_[array]; }
  Bytes takeBytes() noexcept { return std::move(bytes_); }
  /// Arrays of the bytes themselves, which must live as long.
  vtkSmartPointer<vtkCellData> cellData(const std::vector<SharedArray>& arrays);

private:
  std::size_t layOut(std::size_t keyBytes, const std::vector<SharedArray>& arrays);

  std::size_t count_ = 0;
  std::vector<std::size_t> starts_; // of each array
  Bytes bytes_;
};

} // namespace treeamr
