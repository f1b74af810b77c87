// Debian's TBB is not built with the thread sanitizer, which therefore sees none of the order that TBB makes between
// threads and takes each hand-over of work for a race. These stand in front of TBB's entry points and tell it: what
// was before a task's spawning is before the task, and what tasks did is before the end of the wait for them. All the
// rest (counts of pending tasks, containers) are atomics in TBB's headers, which it sees.
#include <oneapi/tbb/parallel_for.h>

#include <sanitizer/tsan_interface.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <dlfcn.h>
#include <new>

/// Left out are TBB's own calls of the C library, and Embree's, which is not built with it either: it frees on one
/// thread what another has allocated. That Embree's build has ended when the call returns is not seen, so left out is
/// what that calls back, which only reads; not what rays call back. Mesa's software driver has threads of its own.
extern "C" const char* __tsan_default_suppressions()
{
  return "called_from_lib:libtbb.so\n"
         "called_from_lib:libembree3.so\n"
         "called_from_lib:libembree4.so\n"
         "race:treeamr::*::Impl::bounds\n"
         "race:swrast_dri.so";
}

namespace tbb::detail
{

namespace
{

template <class Function>
Function original(const char* name)
{
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Takes a task's place in TBB's queues.
class Relay : public d1::task
{
public:
  explicit Relay(d1::task& task)
    : task_(task)
  {
    __tsan_release(this);
  }
  // Not the global ones, which tests replace.
  static void* operator new(std::size_t size) { return r1::cache_aligned_allocate(size); }
  static void operator delete(void* memory) { r1::cache_aligned_deallocate(memory); }
  d1::task* execute(d1::execution_data& data) override
  {
    return pass([&](d1::task& task) { return task.execute(data); });
  }
  d1::task* cancel(d1::execution_data& data) override
  {
    return pass([&](d1::task& task) { return task.cancel(data); });
  }

private:
  /// After an exception TBB cancels the same task.
  template <class Call>
  d1::task* pass(const Call& call)
  {
    __tsan_acquire(this);
    d1::task* const next = call(task_);
    delete this;
    return next;
  }

  d1::task& task_;
};

/// Ends a wait, by an exception, too: the last of the tasks has released the count of pending ones.
class Waiting
{
public:
  explicit Waiting(d1::wait_context& waited)
    : waited_(waited)
  {
  }
  ~Waiting() { __tsan_acquire(reinterpret_cast<char*>(&waited_) + countOffset); }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

private:
  static constexpr std::size_t countOffset = sizeof(std::uint64_t);
  static_assert(sizeof(d1::wait_context) == 2 * countOffset);

  d1::wait_context& waited_;
};

} // namespace

namespace r1
{

void spawn(d1::task& task, d1::task_group_context& context)
{
  original<void (*)(d1::task&, d1::task_group_context&)>(
    "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE")(*new Relay(task), context);
}

void spawn(d1::task& task, d1::task_group_context& context, d1::slot_id slot)
{
  original<void (*)(d1::task&, d1::task_group_context&, d1::slot_id)>(
    "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt")(*new Relay(task), context, slot);
}

void execute_and_wait(
  d1::task& task, d1::task_group_context& context, d1::wait_context& waited, d1::task_group_context& waiting)
{
  const Waiting end(waited);
  original<void (*)(d1::task&, d1::task_group_context&, d1::wait_context&, d1::task_group_context&)>(
    "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_12wait_contextES6_")(
    task, context, waited, waiting);
}

void wait(d1::wait_context& waited, d1::task_group_context& context)
{
  const Waiting end(waited);
  original<void (*)(d1::wait_context&, d1::task_group_context&)>(
    "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE")(waited, context);
}

// Memory that goes from thread to thread, also inside TBB: a spawn to a slot makes a proxy that another thread frees.

void* allocate(d1::small_object_pool*&, std::size_t size)
{
  return cache_aligned_allocate(size);
}

void* allocate(d1::small_object_pool*&, std::size_t size, const d1::execution_data&)
{
  return cache_aligned_allocate(size);
}

void deallocate(d1::small_object_pool&, void* memory, std::size_t)
{
  cache_aligned_deallocate(memory);
}

void deallocate(d1::small_object_pool&, void* memory, std::size_t, const d1::execution_data&)
{
  cache_aligned_deallocate(memory);
}

void* cache_aligned_allocate(std::size_t size)
{
  constexpr std::size_t line = 128;
  void* const memory = std::aligned_alloc(line, (size + line - 1) / line * line);
  if (!memory)
  {
    throw std::bad_alloc();
  }
  __tsan_release(memory);
  return memory;
}

void cache_aligned_deallocate(void* memory)
{
  __tsan_acquire(memory);
  std::free(memory);
}

} // namespace r1

} // namespace tbb::detail
