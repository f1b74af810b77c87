// One cell array of the reader's grid each, filled leaf by leaf. Private to the reader.
#pragma once

#include "LargeDataArray.h"
#include "P4estForestFile.h"
#include "PayloadLayout.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkCellData.h"
#include "vtkSmartPointer.h"
#include "vtkTypeTraits.h"

#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

namespace treeamr
{

constexpr const char* levelArrayName = "level";
constexpr const char* treeIdArrayName = "treeid";

/// Children before their parent.
class ArrayFiller
{
public:
  virtual ~ArrayFiller() = default;
  virtual void setLeaf(vtkIdType node, const P4estQuadrant& leaf) = 0;
  virtual void setInner(vtkIdType node, vtkIdType firstChild) = 0;
};
using ArrayFillers = std::vector<std::unique_ptr<ArrayFiller>>;

template <class T>
class TypedFiller : public ArrayFiller
{
protected:
  TypedFiller(vtkCellData* cellData, const char* name, int components, vtkIdType nodes)
    : components_(components)
  {
    // Not vtkAOSDataArrayTemplate::New(): that is no vtkDoubleArray, vtkIntArray ... to those who ask.
    const auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(vtkTypeTraits<T>::VTKTypeID()));
    array->SetName(name);
    array->SetNumberOfComponents(components);
    auto* const typed = vtkAOSDataArrayTemplate<T>::FastDownCast(array);
    allocateTuples(typed, nodes);
    cellData->AddArray(array);
    values_ = typed->GetPointer(0);
  }
  T* tuple(vtkIdType node) { return values_ + node * components_; }

  int components_;

private:
  T* values_; // owned by the array
};

template <class T>
class PayloadFiller : public TypedFiller<T>
{
public:
  PayloadFiller(vtkCellData* cellData, const PayloadField& field, vtkIdType nodes)
    : TypedFiller<T>(cellData, field.name.c_str(), field.components, nodes)
    , offset_(field.offset)
  {
  }
  void setLeaf(vtkIdType node, const P4estQuadrant& leaf) override
  {
    std::memcpy(this->tuple(node), leaf.payload + offset_, this->components_ * sizeof(T));
  }
  void setInner(vtkIdType node, vtkIdType firstChild) override
  {
    T* const value = this->tuple(node);
    const T* const children = this->tuple(firstChild);
    for (int c = 0; c < this->components_; ++c)
    {
      if constexpr (std::is_floating_point_v<T>)
      {
        double sum = 0.;
        for (int child = 0; child < 8; ++child)
        {
          sum += children[child * this->components_ + c];
        }
        value[c] = static_cast<T>(sum / 8.);
      }
      else
      {
        value[c] = children[c];
      }
    }
  }

private:
  std::size_t offset_;
};

class LevelFiller : public TypedFiller<unsigned char>
{
public:
  LevelFiller(vtkCellData* cellData, vtkIdType nodes)
    : TypedFiller(cellData, levelArrayName, 1, nodes)
  {
  }
  void setLeaf(vtkIdType node, const P4estQuadrant& leaf) override
  {
    *tuple(node) = static_cast<unsigned char>(leaf.level);
  }
  void setInner(vtkIdType node, vtkIdType firstChild) override
  {
    *tuple(node) = static_cast<unsigned char>(*tuple(firstChild) - 1);
  }
};

class TreeIdFiller : public TypedFiller<int>
{
public:
  TreeIdFiller(vtkCellData* cellData, vtkIdType nodes)
    : TypedFiller(cellData, treeIdArrayName, 1, nodes)
  {
  }
  void setLeaf(vtkIdType node, const P4estQuadrant& leaf) override { *tuple(node) = leaf.tree; }
  void setInner(vtkIdType node, vtkIdType firstChild) override { *tuple(node) = *tuple(firstChild); }
};

inline std::unique_ptr<ArrayFiller> makeFiller(
  vtkCellData* cellData, const PayloadField& field, vtkIdType nodes)
{
  switch (field.type)
  {
    case PayloadType::Int8:
      return std::make_unique<PayloadFiller<vtkTypeInt8>>(cellData, field, nodes);
    case PayloadType::UInt8:
      return std::make_unique<PayloadFiller<vtkTypeUInt8>>(cellData, field, nodes);
    case PayloadType::Int16:
      return std::make_unique<PayloadFiller<vtkTypeInt16>>(cellData, field, nodes);
    case PayloadType::UInt16:
      return std::make_unique<PayloadFiller<vtkTypeUInt16>>(cellData, field, nodes);
    case PayloadType::Int32:
      return std::make_unique<PayloadFiller<vtkTypeInt32>>(cellData, field, nodes);
    case PayloadType::UInt32:
      return std::make_unique<PayloadFiller<vtkTypeUInt32>>(cellData, field, nodes);
    case PayloadType::Int64:
      return std::make_unique<PayloadFiller<vtkTypeInt64>>(cellData, field, nodes);
    case PayloadType::UInt64:
      return std::make_unique<PayloadFiller<vtkTypeUInt64>>(cellData, field, nodes);
    case PayloadType::Float32:
      return std::make_unique<PayloadFiller<float>>(cellData, field, nodes);
    case PayloadType::Float64:
      return std::make_unique<PayloadFiller<double>>(cellData, field, nodes);
  }
  return nullptr;
}

} // namespace treeamr
