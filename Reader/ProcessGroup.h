// What processes do together: steps that end on all when they fail on one, and messages between any two of them. Private to
// the module.
//
// Every process calls the same functions in the same order; none waits for one that has thrown.
#pragma once

#include "LargeArray.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

class vtkMultiProcessController;

namespace treeamr
{

using Bytes = LargeVector<std::byte>;

class ProcessGroup
{
public:
  explicit ProcessGroup(vtkMultiProcessController& controller);

  int own() const noexcept { return own_; }
  int size() const noexcept { return size_; }
  vtkMultiProcessController& controller() const noexcept { return controller_; }

  /// Runs body() on each process. Throws on all the Error of the first on which it has thrown std::exception, with its number.
  template <class Body>
  void together(const Body& body) const
  {
    Failure failure{};
    try
    {
      body();
    }
    catch (const std::bad_alloc&)
    {
      failure = Failure("not enough memory");
    }
    catch (const std::exception& error)
    {
      failure = Failure(error.what());
    }
    finish(failure);
  }
  bool any(bool isTrue) const;
  /// By process. T: of plain bytes.
  template <class T>
  std::vector<T> gather(const T& value) const
  {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> all;
    together([&] { all.resize(static_cast<std::size_t>(size_)); });
    gatherBytes(&value, all.data(), sizeof(T));
    return all;
  }
  /// Of one of plain bytes, of the same length on all.
  void broadcast(void* data, std::size_t size, int from) const;
  /// outgoing: what each process gets, in their order; freed as it goes. Returns what each has sent. A process' own comes to
  /// itself.
  std::vector<Bytes> exchange(std::vector<Bytes> outgoing) const;

private:
  /// Needs no memory.
  struct Failure
  {
    Failure() = default;
    explicit Failure(const char* what) noexcept
      : isThere(true)
    {
      std::strncpy(text.data(), what, text.size() - 1);
    }
    bool isThere = false;
    std::array<char, 2048> text{};
  };

  void finish(Failure& failure) const;
  void gatherBytes(const void* own, void* all, std::size_t size) const;
  /// Calls talk(partner, whether this process sends first) so that each pair of processes talks once and no one waits for
  /// two.
  template <class Talk>
  void forEachPartner(const Talk& talk) const;

  vtkMultiProcessController& controller_;
  int own_;
  int size_;
};

} // namespace treeamr
