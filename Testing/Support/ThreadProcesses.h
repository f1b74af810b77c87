// Processes as threads of one program, that send each other messages by a vtkMultiProcessController of their own.
//
// A message is sent when it has been received, as large ones are between real processes: who waits for each other never ends,
// which is an exception after half a minute.
#pragma once

#include "vtkAbstractArray.h"
#include "vtkCommunicator.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <vector>

namespace treeamr::test
{

class ThreadMessages
{
public:
  void send(int from, int to, int tag, const void* data, std::size_t size)
  {
    std::unique_lock lock(mutex_);
    Message message{ data, size };
    waiting_[{ from, to, tag }].push_back(&message);
    changed_.notify_all();
    wait(lock, [&] { return message.isReceived; });
    sent += from == to ? 0 : size;
  }
  std::size_t receive(int from, int to, int tag, void* data, std::size_t most)
  {
    std::unique_lock lock(mutex_);
    auto& queue = waiting_[{ from, to, tag }];
    wait(lock, [&] { return !queue.empty(); });
    Message* const message = queue.front();
    queue.pop_front();
    const std::size_t size = std::min(most, message->size);
    std::memcpy(data, message->data, size);
    message->isReceived = true;
    changed_.notify_all();
    return size;
  }

  std::size_t sent = 0; // bytes

private:
  struct Message
  {
    const void* data;
    std::size_t size;
    bool isReceived = false;
  };

  template <class Condition>
  void wait(std::unique_lock<std::mutex>& lock, const Condition& condition)
  {
    if (!changed_.wait_for(lock, std::chrono::seconds(30), condition))
    {
      throw std::runtime_error("nobody answers");
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::tuple<int, int, int>, std::deque<Message*>> waiting_; // by sender, receiver and tag
};

class ThreadCommunicator : public vtkCommunicator
{
public:
  static ThreadCommunicator* New() { VTK_STANDARD_NEW_BODY(ThreadCommunicator); }
  vtkTypeMacro(ThreadCommunicator, vtkCommunicator);

  void join(ThreadMessages& messages, int own, int processes)
  {
    this->Messages = &messages;
    this->MaximumNumberOfProcesses = processes;
    this->NumberOfProcesses = processes;
    this->LocalProcessId = own;
  }
  int SendVoidArray(const void* data, vtkIdType length, int type, int remote, int tag) override
  {
    this->Messages->send(this->LocalProcessId, remote, tag, data,
      static_cast<std::size_t>(length * vtkAbstractArray::GetDataTypeSize(type)));
    return 1;
  }
  int ReceiveVoidArray(void* data, vtkIdType most, int type, int remote, int tag) override
  {
    const int bytes = vtkAbstractArray::GetDataTypeSize(type);
    this->Count = static_cast<vtkIdType>(this->Messages->receive(
                    remote, this->LocalProcessId, tag, data, static_cast<std::size_t>(most * bytes))) /
      bytes;
    return 1;
  }

private:
  ThreadMessages* Messages = nullptr;
};

class ThreadController : public vtkMultiProcessController
{
public:
  static ThreadController* New() { VTK_STANDARD_NEW_BODY(ThreadController); }
  vtkTypeMacro(ThreadController, vtkMultiProcessController);

  void join(ThreadMessages& messages, int own, int processes)
  {
    this->Own->join(messages, own, processes);
    this->Communicator = this->Own;
  }
  void Initialize(int* /*argc*/, char*** /*argv*/) override {}
  void Initialize(int* /*argc*/, char*** /*argv*/, int /*externally*/) override {}
  void Finalize() override {}
  void Finalize(int /*externally*/) override {}
  void SingleMethodExecute() override {}
  void MultipleMethodExecute() override {}
  void CreateOutputWindow() override {}

private:
  vtkSmartPointer<ThreadCommunicator> Own = vtk::TakeSmartPointer(ThreadCommunicator::New());
};

/// Calls body(controller) in each process. Returns how many bytes they have sent.
template <class Body>
std::size_t runProcesses(int count, const Body& body)
{
  ThreadMessages messages;
  std::vector<std::thread> threads;
  for (int own = 0; own < count; ++own)
  {
    threads.emplace_back([&messages, &body, own, count] {
      const auto controller = vtk::TakeSmartPointer(ThreadController::New());
      controller->join(messages, own, count);
      body(*controller);
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  return messages.sent;
}

} // namespace treeamr::test
