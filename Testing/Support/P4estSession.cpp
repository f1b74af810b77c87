#include "Support/P4estSession.h"

#include <p4est.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace treeamr::test
{
namespace
{

class Session
{
public:
  Session()
  {
    int initialized = 0;
    MPI_Initialized(&initialized);
    if (!initialized)
    {
#ifdef __SANITIZE_ADDRESS__
      const __lsan::ScopedDisabler mpiForgets; // some of its memory
#endif
      MPI_Init(nullptr, nullptr);
      ownsMpi_ = true;
    }
    sc_init(MPI_COMM_SELF, 0, 0, nullptr, SC_LP_ERROR);
    p4est_init(nullptr, SC_LP_ERROR);
  }
  ~Session()
  {
#ifdef __SANITIZE_ADDRESS__
    __lsan_do_leak_check(); // the last: what MPI forgets when it ends does not count
#endif
    sc_finalize();
    if (ownsMpi_)
    {
      MPI_Finalize();
    }
  }
  bool ownsMpi_ = false;
};

} // namespace

void startP4est()
{
  static const Session session;
}

} // namespace treeamr::test
