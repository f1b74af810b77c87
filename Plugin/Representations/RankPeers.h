// The processes of ParaView that draw the other boxes of a grid, by MPI: ranks have the numbers of their boxes.
#pragma once

#include "Partition/BoxPeers.h"

#include <memory>

class vtkMultiProcessController;

class RankPeers : public treeamr::BoxPeers
{
public:
  /// Null where processes have no messages that one need not wait for.
  static std::shared_ptr<RankPeers> make(vtkMultiProcessController* controller);

  /// On all ranks, before each frame: whether this one draws something in it.
  virtual void agreeOnDrawing(bool draws) = 0;
};
