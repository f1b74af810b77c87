// Whether the pieces that a filter is asked for are those of many processes. Private to the module.
#pragma once

#include "vtkInformation.h"
#include "vtkMultiProcessController.h"
#include "vtkStreamingDemandDrivenPipeline.h"

namespace treeamr
{

/// Of the processes that each ask for a piece of their own, as ParaView's do; null where one process has all. output: of the
/// filter's.
inline vtkMultiProcessController* pieceController(vtkInformation* output)
{
  using SDDP = vtkStreamingDemandDrivenPipeline;
  vtkMultiProcessController* const controller = vtkMultiProcessController::GetGlobalController();
  const bool hasPieces = controller && controller->GetNumberOfProcesses() > 1 &&
    output->Has(SDDP::UPDATE_NUMBER_OF_PIECES()) && output->Has(SDDP::UPDATE_PIECE_NUMBER()) &&
    output->Get(SDDP::UPDATE_NUMBER_OF_PIECES()) == controller->GetNumberOfProcesses() &&
    output->Get(SDDP::UPDATE_PIECE_NUMBER()) == controller->GetLocalProcessId();
  return hasPieces ? controller : nullptr;
}

} // namespace treeamr
