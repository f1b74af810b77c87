// Frames and executions repeat; messages should not.
#pragma once

#include <set>
#include <string>

namespace treeamr
{

/// A message is said once until it goes away, whatever else changes meanwhile. Not safe from several threads.
class OnceReporter
{
public:
  /// Of all that is wrong in a round (a frame, an execution): true for what was not in the last one. about: the
  /// message, or the part that stays the same where numbers in it vary from round to round.
  bool isNews(const std::string& about)
  {
    const bool isFirst = now_.insert(about).second;
    return isFirst && !last_.contains(about);
  }
  /// What has not come up since the last call has gone away, and is news when it comes back.
  void endRound()
  {
    last_.swap(now_);
    now_.clear();
  }

private:
  std::set<std::string> last_;
  std::set<std::string> now_;
};

} // namespace treeamr
