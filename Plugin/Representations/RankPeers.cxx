#include "RankPeers.h"

#include "vtkMultiProcessController.h"

#if VTK_MODULE_ENABLE_VTK_ParallelMPI
#include "Error.h"

#include "vtkMPICommunicator.h"
#include "vtkMPIController.h"
#include "vtkSmartPointer.h"

#include <cstddef>
#include <list>
#include <utility>
#include <vector>

namespace
{

class MPIPeers : public RankPeers
{
public:
  explicit MPIPeers(vtkMPIController* controller)
    : Controller(controller)
  {
  }

  void agreeOnDrawing(bool draws) override
  {
    const int own = draws ? 1 : 0;
    std::vector<int> all(static_cast<std::size_t>(this->Controller->GetNumberOfProcesses()));
    this->Controller->AllGather(&own, all.data(), 1);
    this->Drawing.assign(all.begin(), all.end());
  }

  const std::vector<bool>& drawing() const override { return this->Drawing; }

  void send(int peer, Channel channel, std::vector<float> numbers) override
  {
    this->Sent.remove_if([](Message& message) { return message.Request.Test() != 0; });
    Message& message = this->Sent.emplace_back();
    message.Numbers = std::move(numbers);
    check(this->Controller->NoBlockSend(message.Numbers.data(), static_cast<int>(message.Numbers.size()), peer,
      TagOf(channel), message.Request));
  }

  int receive(int peer, Channel channel, std::vector<float>& numbers) override
  {
    const int from = peer == anyone ? static_cast<int>(vtkMultiProcessController::ANY_SOURCE) : peer;
    int hasCome = 0;
    int sender = anyone;
    int size = 0;
    float type = 0.f; // tells it from others
    check(this->Controller->Iprobe(from, TagOf(channel), &hasCome, &sender, &type, &size));
    if (!hasCome)
    {
      return anyone;
    }
    numbers.resize(static_cast<std::size_t>(size));
    check(this->Controller->Receive(numbers.data(), size, sender, TagOf(channel)));
    return sender;
  }

private:
  struct Message
  {
    std::vector<float> Numbers;
    vtkMPICommunicator::Request Request;
  };

  static void check(int isDone)
  {
    if (!isDone)
    {
      throw treeamr::Error("messages between processes fail: MPI reports an error");
    }
  }

  /// That nobody else uses.
  static int TagOf(Channel channel)
  {
    constexpr int first = 58110;
    return first + static_cast<int>(channel);
  }

  vtkSmartPointer<vtkMPIController> Controller;
  std::vector<bool> Drawing;
  std::list<Message> Sent; // that may not have gone yet
};

} // namespace
#endif

//------------------------------------------------------------------------------
std::shared_ptr<RankPeers> RankPeers::make(vtkMultiProcessController* controller)
{
#if VTK_MODULE_ENABLE_VTK_ParallelMPI
  if (auto ofMPI = vtkMPIController::SafeDownCast(controller))
  {
    return std::make_shared<MPIPeers>(ofMPI);
  }
#else
  static_cast<void>(controller);
#endif
  return nullptr;
}
