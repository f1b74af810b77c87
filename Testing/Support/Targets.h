// Every instruction set that Highway chooses from.
#pragma once

#include "InstructionSets.h"

#include <hwy/targets.h>

#include <cstdint>

namespace treeamr::test
{

/// Calls f with the name of each instruction set that kernels were compiled for and this machine has.
template <class F>
void forEachTarget(const F& f)
{
  std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
#ifdef __SANITIZE_THREAD__
  // Threads meet in the same places whatever the instructions are: the best set stands for all.
  targets &= -targets;
#endif
  for (; targets != 0; targets &= targets - 1)
  {
    const std::int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    f(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

} // namespace treeamr::test
