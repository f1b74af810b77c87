// What all programs need that use libp4est.
#pragma once

namespace treeamr::test
{

/// libp4est asks for MPI even when there is but one process. Both end with the program.
void startP4est();

} // namespace treeamr::test
