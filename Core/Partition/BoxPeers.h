// Processes that draw boxes of one domain, as one of them sees the others: who draws, and messages.
#pragma once

#include <vector>

namespace treeamr
{

/// By the numbers of their boxes.
class BoxPeers
{
public:
  enum class Channel
  {
    Agreement,
    Tiles
  };
  static constexpr int anyone = -1;

  virtual ~BoxPeers() = default;
  /// Of each whether it draws something, this one included; the same on all that do.
  virtual const std::vector<bool>& drawing() const = 0;
  /// Without waiting for anybody.
  virtual void send(int peer, Channel channel, std::vector<float> numbers) = 0;
  /// What a peer or anyone has sent, in the order of each sender, if it has come: from whom, or anyone when nothing has.
  virtual int receive(int peer, Channel channel, std::vector<float>& numbers) = 0;
};

} // namespace treeamr
