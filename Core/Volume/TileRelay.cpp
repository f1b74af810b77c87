#include "Volume/TileRelay.h"

#include <oneapi/tbb/task_group.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <utility>

namespace treeamr
{

namespace
{

/// What is to be rendered, and what has been.
class RunQueue
{
public:
  explicit RunQueue(const std::function<void(const TileRun&)>& render)
    : render_(render)
  {
  }

  void add(const TileRun& run)
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(run);
  }

  /// By any thread; false when there is nothing to do.
  bool renderOne()
  {
    std::unique_lock lock(mutex_);
    if (waiting_.empty())
    {
      return false;
    }
    const TileRun run = waiting_.front();
    waiting_.pop_front();
    const bool isLeft = error_ != nullptr;
    lock.unlock();
    std::exception_ptr error;
    try
    {
      if (!isLeft)
      {
        render_(run);
      }
    }
    catch (...)
    {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error_ ? error_ : error;
    done_.push_back(run);
    isDone_.notify_one();
    return true;
  }

  std::vector<TileRun> takeDone()
  {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
  }

  /// Until something is done, or others may have sent something: they need the processor meanwhile.
  void rest()
  {
    std::unique_lock lock(mutex_);
    isDone_.wait_for(lock, std::chrono::microseconds(100), [this] { return !done_.empty(); });
  }

  void throwError() const
  {
    if (error_)
    {
      std::rethrow_exception(error_);
    }
  }

private:
  const std::function<void(const TileRun&)>& render_;
  std::mutex mutex_;
  std::condition_variable isDone_;
  std::deque<TileRun> waiting_;
  std::vector<TileRun> done_;
  std::exception_ptr error_;
};

/// A task group whose tasks are over when it is.
struct Tasks : tbb::task_group
{
  ~Tasks() { this->wait(); }
};

} // namespace

void relayTiles(TileRelay& relay, const std::function<void(const TileRun&)>& render)
{
  RunQueue queue(render);
  {
    Tasks tasks;
    std::vector<TileRun> ready;
    std::size_t open = 0; // runs that are not finished
    for (bool isMore = true; isMore || open > 0;)
    {
      ready.clear();
      isMore = isMore && relay.collect(ready);
      for (const TileRun& run : ready)
      {
        queue.add(run);
        tasks.run([&queue] { queue.renderOne(); });
      }
      open += ready.size();
      const std::vector<TileRun> done = queue.takeDone();
      for (const TileRun& run : done)
      {
        relay.finish(run);
      }
      open -= done.size();
      if (ready.empty() && done.empty() && !queue.renderOne())
      {
        queue.rest();
      }
    }
  }
  queue.throwError();
}

} // namespace treeamr
