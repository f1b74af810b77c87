#include "ProcessGroup.h"

#include "Error.h"

#include "vtkCommunicator.h"
#include "vtkMultiProcessController.h"

#include <algorithm>
#include <bit>

namespace treeamr
{

namespace
{

constexpr int tag = 7326;

/// Calls body(first byte, count) of pieces that a count of type int has room for.
template <class Body>
void inPieces(std::size_t size, const Body& body)
{
  constexpr std::size_t most = std::size_t(1) << 30;
  for (std::size_t begin = 0; begin < size; begin += most)
  {
    body(begin, static_cast<vtkIdType>(std::min(most, size - begin)));
  }
}

char* chars(void* data)
{
  return static_cast<char*>(data);
}

} // namespace

ProcessGroup::ProcessGroup(vtkMultiProcessController& controller)
  : controller_(controller)
  , own_(controller.GetLocalProcessId())
  , size_(controller.GetNumberOfProcesses())
{
}

void ProcessGroup::finish(Failure& failure) const
{
  const int failed = failure.isThere ? own_ : size_;
  int first = size_;
  controller_.AllReduce(&failed, &first, 1, vtkCommunicator::MIN_OP);
  if (first < size_)
  {
    broadcast(failure.text.data(), failure.text.size(), first);
    throw Error("process " + std::to_string(first) + ": " + failure.text.data());
  }
}

bool ProcessGroup::any(bool isTrue) const
{
  const int own = isTrue ? 1 : 0;
  int most = own;
  controller_.AllReduce(&own, &most, 1, vtkCommunicator::MAX_OP);
  return most != 0;
}

void ProcessGroup::gatherBytes(const void* own, void* all, std::size_t size) const
{
  controller_.AllGather(static_cast<const char*>(own), chars(all), static_cast<vtkIdType>(size));
}

void ProcessGroup::broadcast(void* data, std::size_t size, int from) const
{
  inPieces(size,
    [&](std::size_t begin, vtkIdType count) { controller_.Broadcast(chars(data) + begin, count, from); });
}

template <class Talk>
void ProcessGroup::forEachPartner(const Talk& talk) const
{
  // In each round the processes whose numbers differ by the same bits are pairs.
  const int rounds = static_cast<int>(std::bit_ceil(static_cast<unsigned>(size_)));
  for (int round = 1; round < rounds; ++round)
  {
    const int partner = own_ ^ round;
    if (partner < size_)
    {
      talk(partner, own_ < partner);
    }
  }
}

std::vector<Bytes> ProcessGroup::exchange(std::vector<Bytes> outgoing) const
{
  std::vector<Bytes> incoming;
  std::vector<vtkIdType> sizes;
  together([&] {
    incoming.resize(static_cast<std::size_t>(size_));
    sizes.resize(static_cast<std::size_t>(size_));
  });
  forEachPartner([&](int partner, bool isFirst) {
    const auto size = static_cast<vtkIdType>(outgoing[partner].size());
    for (const bool sends : { isFirst, !isFirst })
    {
      sends ? controller_.Send(&size, 1, partner, tag)
            : controller_.Receive(&sizes[partner], 1, partner, tag);
    }
  });
  together([&] {
    for (int process = 0; process < size_; ++process)
    {
      incoming[process].resize(static_cast<std::size_t>(sizes[process]));
    }
  });
  incoming[own_] = std::move(outgoing[own_]);
  forEachPartner([&](int partner, bool isFirst) {
    for (const bool sends : { isFirst, !isFirst })
    {
      Bytes& bytes = sends ? outgoing[partner] : incoming[partner];
      inPieces(bytes.size(), [&](std::size_t begin, vtkIdType count) {
        char* const piece = chars(bytes.data()) + begin;
        sends ? controller_.Send(piece, count, partner, tag)
              : controller_.Receive(piece, count, partner, tag);
      });
    }
    outgoing[partner] = {};
  });
  return incoming;
}

} // namespace treeamr
