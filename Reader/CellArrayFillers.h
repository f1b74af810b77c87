// One cell array each of a grid that is built from its leaves (HyperTreeGridBuilder.h), filled leaf by leaf, by several
// threads. Private to the module.
#pragma once

#include "CornerArrays.h"
#include "Forest/PayloadLayout.h"
#include "Forest/TreeLattice.h"
#include "Forest/TreeLeaf.h"
#include "LargeDataArray.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkDataSetAttributes.h"
#include "vtkSmartPointer.h"
#include "vtkTypeTraits.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace treeamr
{

constexpr const char* levelArrayName = "level";
constexpr const char* treeIdArrayName = "treeid";

/// Children before their parent.
class CellArrayFiller
{
public:
  virtual ~CellArrayFiller() = default;
  virtual void setLeaf(vtkIdType node, const TreeLeaf& leaf) = 0;
  /// Of leaves that follow each other.
  virtual void setLeaves(const std::vector<TreeLeaf>& leaves, const vtkIdType* nodes)
  {
    for (std::size_t i = 0; i < leaves.size(); ++i)
    {
      setLeaf(nodes[i], leaves[i]);
    }
  }
  /// Told some leaves before that of this number, whose values may lie anywhere.
  virtual void prepare(std::uint64_t /*number*/) const {}
  /// present: mask of the children that have cells, one at least.
  virtual void setInner(vtkIdType node, vtkIdType firstChild, unsigned present) = 0;
  /// Where there is no cell, as another child of the same parent.
  virtual void setMissing(vtkIdType node, vtkIdType sibling) = 0;
  virtual vtkAbstractArray* array() const noexcept = 0;
};

/// An inner node and its children without cells, which have a value of those with one: VTK's ranges of arrays count masked
/// cells, too.
inline void fillFamily(
  CellArrayFiller& filler, vtkIdType node, vtkIdType firstChild, unsigned present, unsigned all = 0xff)
{
  for (unsigned missing = ~present & all; missing != 0; missing &= missing - 1)
  {
    filler.setMissing(firstChild + std::countr_zero(missing), firstChild + std::countr_zero(present));
  }
  filler.setInner(node, firstChild, present);
}

template <class T>
class TypedFiller : public CellArrayFiller
{
public:
  void setMissing(vtkIdType node, vtkIdType sibling) override
  {
    std::copy_n(tuple(sibling), components_, tuple(node));
  }
  vtkDataArray* array() const noexcept override { return array_; }

protected:
  /// type: VTK's number of it, for T may be that of several (vtkIdType).
  TypedFiller(const char* name, int components, vtkIdType nodes, int type = vtkTypeTraits<T>::VTKTypeID())
    // Not vtkAOSDataArrayTemplate::New(): that is no vtkDoubleArray, vtkIntArray ... to those who ask.
    : array_(vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type)))
    , components_(components)
  {
    array_->SetName(name);
    array_->SetNumberOfComponents(components);
    auto* const typed = vtkAOSDataArrayTemplate<T>::FastDownCast(array_);
    allocateTuples(typed, nodes);
    values_ = typed->GetPointer(0);
  }
  T* tuple(vtkIdType node) { return values_ + node * components_; }

private:
  vtkSmartPointer<vtkDataArray> array_;
  T* values_; // of the array

protected:
  int components_;
};

/// An inner node has the mean of its children, or of integers the first one's.
template <class T>
class BlendedFiller : public TypedFiller<T>
{
public:
  using TypedFiller<T>::TypedFiller;

  void setInner(vtkIdType node, vtkIdType firstChild, unsigned present) override
  {
    T* const value = this->tuple(node);
    const T* const children = this->tuple(firstChild);
    [[maybe_unused]] const double count = present == 0xff ? 8 : std::popcount(present);
    for (int c = 0; c < this->components_; ++c)
    {
      if constexpr (std::is_floating_point_v<T>)
      {
        double sum = 0.;
        for (unsigned child = 0; child < 8; ++child)
        {
          sum += present >> child & 1 ? children[child * this->components_ + c] : 0.;
        }
        value[c] = static_cast<T>(sum / count);
      }
      else
      {
        value[c] = children[std::countr_zero(present) * this->components_ + c];
      }
    }
  }
};

/// A member of the leaves' payload.
template <class T>
class PayloadFiller : public BlendedFiller<T>
{
public:
  PayloadFiller(const PayloadField& field, vtkIdType nodes)
    : BlendedFiller<T>(field.name.c_str(), field.components, nodes)
    , offset_(field.offset)
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    std::memcpy(this->tuple(node), leaf.payload + offset_, this->components_ * sizeof(T));
  }

private:
  std::size_t offset_;
};

/// Sums of a payload's values, each times its weight.
template <class T>
class SumFiller : public BlendedFiller<T>
{
public:
  SumFiller(const PayloadField& field, vtkIdType nodes)
    : BlendedFiller<T>(field.name.c_str(), field.components, nodes)
    , field_(field)
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const std::byte* const values = leaf.payload + field_.offset;
    T* const tuple = this->tuple(node);
    for (int c = 0; c < this->components_; ++c)
    {
      double sum = 0.;
      for (const PayloadField::Term& term : field_.sums[c])
      {
        T value;
        std::memcpy(&value, values + term.index * sizeof(T), sizeof(T));
        sum += term.weight * value;
      }
      tuple[c] = static_cast<T>(sum);
    }
  }

private:
  PayloadField field_;
};

/// Values at the corners of leaves. An inner node has those at its own corners.
template <class T>
class CornersFiller : public TypedFiller<T>
{
public:
  CornersFiller(const char* name, vtkIdType nodes, int type = vtkTypeTraits<T>::VTKTypeID())
    : TypedFiller<T>(name, cornerCount, nodes, type)
  {
    markAsCorners(*this->array());
  }
  void setInner(vtkIdType node, vtkIdType firstChild, unsigned /*present*/) override
  {
    for (int c = 0; c < cornerCount; ++c)
    {
      this->tuple(node)[c] = this->tuple(firstChild + c)[c];
    }
  }
};

/// Of a payload, in the order of the grid's axes.
template <class T>
class PayloadCornersFiller : public CornersFiller<T>
{
public:
  /// lattice: kept by reference.
  PayloadCornersFiller(const PayloadField& field, vtkIdType nodes, const TreeLattice& lattice)
    : CornersFiller<T>(field.name.c_str(), nodes)
    , field_(field)
    , lattice_(lattice)
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const TreeOrientation& orientation = lattice_.orientation(leaf.tree);
    for (int c = 0; c < cornerCount; ++c)
    {
      std::memcpy(this->tuple(node) + orientation[c],
        leaf.payload + field_.offset + field_.sums[c][0].index * sizeof(T), sizeof(T));
    }
  }

private:
  PayloadField field_;
  const TreeLattice& lattice_;
};

class LevelFiller : public TypedFiller<unsigned char>
{
public:
  explicit LevelFiller(vtkIdType nodes)
    : TypedFiller(levelArrayName, 1, nodes)
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    *tuple(node) = static_cast<unsigned char>(leaf.level);
  }
  void setInner(vtkIdType node, vtkIdType firstChild, unsigned /*present*/) override
  {
    *tuple(node) = static_cast<unsigned char>(*tuple(firstChild) - 1);
  }
};

class TreeIdFiller : public TypedFiller<int>
{
public:
  explicit TreeIdFiller(vtkIdType nodes)
    : TypedFiller(treeIdArrayName, 1, nodes)
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override { *tuple(node) = leaf.tree; }
  void setInner(vtkIdType node, vtkIdType firstChild, unsigned /*present*/) override
  {
    *tuple(node) = *tuple(firstChild);
  }
};

/// vtkGhostType of cells that another process has, too, and counts.
class GhostFiller : public TypedFiller<unsigned char>
{
public:
  /// isGhost: of a leaf, called by several threads.
  GhostFiller(vtkIdType nodes, std::function<bool(const TreeLeaf&)> isGhost)
    : TypedFiller(vtkDataSetAttributes::GhostArrayName(), 1, nodes)
    , isGhost_(std::move(isGhost))
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    *tuple(node) = isGhost_(leaf) ? vtkDataSetAttributes::DUPLICATECELL : 0;
  }
  void setInner(vtkIdType node, vtkIdType /*firstChild*/, unsigned /*present*/) override { *tuple(node) = 0; }
  void setMissing(vtkIdType node, vtkIdType /*sibling*/) override { *tuple(node) = 0; }

private:
  std::function<bool(const TreeLeaf&)> isGhost_;
};

/// Of values at corners. lattice: the trees', kept by reference.
inline std::unique_ptr<CellArrayFiller> makeCornerFiller(
  const PayloadField& field, vtkIdType nodes, const TreeLattice& lattice)
{
  if (field.type == PayloadType::Float32)
  {
    return std::make_unique<PayloadCornersFiller<float>>(field, nodes, lattice);
  }
  return std::make_unique<PayloadCornersFiller<double>>(field, nodes, lattice);
}

/// Of all others.
inline std::unique_ptr<CellArrayFiller> makeFiller(const PayloadField& field, vtkIdType nodes)
{
  if (!field.sums.empty())
  {
    if (field.type == PayloadType::Float32)
    {
      return std::make_unique<SumFiller<float>>(field, nodes);
    }
    return std::make_unique<SumFiller<double>>(field, nodes);
  }
  switch (field.type)
  {
    case PayloadType::Int8:
      return std::make_unique<PayloadFiller<vtkTypeInt8>>(field, nodes);
    case PayloadType::UInt8:
      return std::make_unique<PayloadFiller<vtkTypeUInt8>>(field, nodes);
    case PayloadType::Int16:
      return std::make_unique<PayloadFiller<vtkTypeInt16>>(field, nodes);
    case PayloadType::UInt16:
      return std::make_unique<PayloadFiller<vtkTypeUInt16>>(field, nodes);
    case PayloadType::Int32:
      return std::make_unique<PayloadFiller<vtkTypeInt32>>(field, nodes);
    case PayloadType::UInt32:
      return std::make_unique<PayloadFiller<vtkTypeUInt32>>(field, nodes);
    case PayloadType::Int64:
      return std::make_unique<PayloadFiller<vtkTypeInt64>>(field, nodes);
    case PayloadType::UInt64:
      return std::make_unique<PayloadFiller<vtkTypeUInt64>>(field, nodes);
    case PayloadType::Float32:
      return std::make_unique<PayloadFiller<float>>(field, nodes);
    case PayloadType::Float64:
      return std::make_unique<PayloadFiller<double>>(field, nodes);
  }
  return nullptr;
}

} // namespace treeamr
