// What a long computation tells whoever started it, and how that one ends it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>
#include <utility>

namespace treeamr
{

/// Thrown out of a computation that was ended: no std::exception, for no error is to be reported.
struct Interrupted
{
};

/// Made by the thread that computes, with all others or without. Not reused once it has thrown.
class Progress
{
public:
  /// Part of the present work that is done, from 0 to 1; false ends it.
  using Report = std::function<bool(double)>;

  /// report: called by this thread alone, amid the computation, at most once in an interval and not before the first one.
  explicit Progress(
    Report report, std::chrono::steady_clock::duration interval = std::chrono::milliseconds(50))
    : report_(std::move(report))
    , interval_(interval)
    , next_(std::chrono::steady_clock::now() + interval)
  {
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Work of so many steps begins. While no thread calls step().
  void begin(std::size_t steps) noexcept
  {
    steps_ = steps;
    done_.store(0, std::memory_order_relaxed);
  }
  /// So many have been done. From any thread, where all may be left as it is: throws Interrupted when the work is to end,
  /// and whatever the report throws.
  void step(std::size_t count = 1)
  {
    done_.fetch_add(count, std::memory_order_relaxed);
    if (std::this_thread::get_id() == owner_ && std::chrono::steady_clock::now() >= next_)
    {
      this->report();
    }
    if (isEnded_.load(std::memory_order_relaxed))
    {
      throw Interrupted();
    }
  }

private:
  void report()
  {
    // Not again from within, should the report compute something that this thread takes part in.
    next_ = std::chrono::steady_clock::time_point::max();
    const std::size_t done = done_.load(std::memory_order_relaxed);
    const bool goesOn = report_(done < steps_ ? static_cast<double>(done) / static_cast<double>(steps_) : 1.);
    isEnded_.store(!goesOn, std::memory_order_relaxed);
    next_ = std::chrono::steady_clock::now() + interval_;
  }

  Report report_;
  std::chrono::steady_clock::duration interval_;
  std::chrono::steady_clock::time_point next_; // of the owner
  std::thread::id owner_ = std::this_thread::get_id();
  std::size_t steps_ = 1;
  std::atomic<std::size_t> done_{ 0 };
  std::atomic<bool> isEnded_{ false };
};

} // namespace treeamr
