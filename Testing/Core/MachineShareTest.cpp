// Memory of a machine, divided among its processes.
#include "MachineShare.h"

#include <gtest/gtest.h>

using namespace treeamr;

TEST(MachineShare, IsOfAllProcessesAlike)
{
  EXPECT_EQ(shareOfMachine(100), 100u);
  setProcessesOnMachine(4);
  EXPECT_EQ(shareOfMachine(100), 25u);
  setProcessesOnMachine(0); // there is one, whatever is said
  EXPECT_EQ(shareOfMachine(100), 100u);
}
